// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points where a backend evaluates them: of one structure, host_points.h and cuda/points/cuda_points.h; of several,
// summed_points.h. The calls, their formulas and layouts are those of point_derivatives.h.
//
// All implementations give the same values within 1e-12 of their sizes, and each the same bits at every call.
//
// Errors   what `stop` says; of a device kResourceExhausted and kUnavailable; then the output is not complete
// Threads  safe: several calls may run at once
#ifndef LATTICED_CORE_POINTS_POINT_EVALUATOR_H_
#define LATTICED_CORE_POINTS_POINT_EVALUATOR_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/points/point_derivatives.h"
#include "core/points/sorted_points.h"

namespace latticed {

class PointEvaluator {
 public:
  virtual ~PointEvaluator() = default;

  // Of several structures, sorted for the first one.
  virtual const SortedPoints& points() const = 0;
  // Those that no lattice moves.
  [[nodiscard]] virtual size_t points_outside() const {
    return points().size() - points().inside();
  }
  [[nodiscard]] virtual absl::Status Deform(std::span<const Vec3d> control_points,
                                            PointNormals normals, StopCheck stop,
                                            std::span<Vec3d> out) = 0;
  [[nodiscard]] virtual absl::Status ApplyJacobian(std::span<const Vec3d> control_points,
                                                   std::span<const Vec3d> tangents,
                                                   PointNormals normals, StopCheck stop,
                                                   std::span<Vec3d> out) = 0;
  // Overwrites `gradients`.
  [[nodiscard]] virtual absl::Status ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                                            std::span<const Vec3d> cotangents,
                                                            PointNormals normals, StopCheck stop,
                                                            std::span<Vec3d> gradients) = 0;
  // The host memory that Deform, for one direction, and ApplyJacobian take while they run, beside their arguments.
  [[nodiscard]] virtual uint64_t ForwardBytes(size_t /*directions*/,
                                              PointNormals /*normals*/) const {
    return 0;  // little
  }
  // The same of ApplyJacobianTranspose.
  [[nodiscard]] virtual uint64_t TransposeBytes(size_t directions, PointNormals normals) const = 0;
  // What it keeps on a device while it lives.
  [[nodiscard]] virtual uint64_t device_bytes() const { return 0; }
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_POINT_EVALUATOR_H_
