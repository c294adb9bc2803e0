// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of a view by the definition (core/ffd/direct_ffd.h), and how far from them a pipeline
// may be (tests/support/tolerances.h).
#ifndef LATTICED_TESTS_BACKEND_DEFINITION_H_
#define LATTICED_TESTS_BACKEND_DEFINITION_H_

#include <array>
#include <span>
#include <vector>

#include "tests/support/tolerances.h"

namespace latticed::testing {

class Definition {
 public:
  // Of every `stride`-th patch. Keeps references to the plan and the control points.
  Definition(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
             NormalMode normals, size_t stride = 1);

  size_t stride() const { return stride_; }
  size_t points_per_patch() const { return barycentrics_.size(); }
  const DirectFfd::SurfacePoint& Point(size_t patch, size_t i) const {
    return points_[patch / stride_ * points_per_patch() + i];
  }
  // D, in world units.
  double scale() const { return scale_; }
  // In rad; infinite where the definition's own normal is ill-conditioned.
  double NormalTolerance(Pipeline pipeline, size_t patch, size_t i) const;

 private:
  const DeformPlan& plan_;
  const DirectFfd direct_;
  const DirectFfd::Normal kind_;
  const size_t stride_;
  std::vector<std::array<double, 3>> barycentrics_;
  std::vector<DirectFfd::SurfacePoint> points_;
  std::vector<double> patch_diagonals_;
  double scale_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_DEFINITION_H_
