// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the points of a view with the definition in double precision (core/ffd/direct_ffd.h).
//
//   position  within PositionTolerance() * D, D = max(diagonal of the deformed points, diagonal of
//             the control points that influence the mesh)
//   normal    length 1 within kUnitTolerance. Where kappa <= kMostKappa, the angle in rad is within
//             kFusedNormal * kappa (fused; with weights (kFusedNormal + kFusedPosition * D
//             |grad w|) * kappa), or within the rounding of the products, carried over to
//             the cross product (all others)
//
// Two backends or pipelines agree within the sum of their tolerances.
//
// Threads  pure functions
#ifndef LATTICED_TESTS_SUPPORT_DEFINITION_H_
#define LATTICED_TESTS_SUPPORT_DEFINITION_H_

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/ffd/direct_ffd.h"

namespace latticed::testing {

inline constexpr double kFusedPosition = 3e-7;
inline constexpr double kGemmPosition = 1e-6;
inline constexpr double kFusedNormal = 2e-5;
inline constexpr double kMostKappa = 100;
inline constexpr double kUnitTolerance = 1e-6;

[[nodiscard]] constexpr double PositionTolerance(Pipeline pipeline) {
  return pipeline == Pipeline::kFused ? kFusedPosition : kGemmPosition;
}

// In rad.
[[nodiscard]] double Angle(Vec3d a, Vec3d b);

struct ViewPoint {
  Vec3d position;  // in world coordinates
  Vec3d normal;    // as stored; zero without normals
};
// Decodes whole points from the layout in which they are sent.
[[nodiscard]] std::vector<ViewPoint> DecodePoints(const DeformPlan& plan, const ViewSpec& spec,
                                                  const QuantisationBox& box,
                                                  std::span<const uint8_t> bytes);

// Rounding to integers adds half a step on each axis to a position. To a normal it adds half a cell's
// diagonal, stretched by at most sqrt(3) from octahedron to sphere, and twice that on the rim, where
// two cells name one direction. Zero for floats.
struct RoundingTolerance {
  double position = 0, normal = 0;
};
[[nodiscard]] RoundingTolerance RoundingOf(const ViewSpec& spec, const QuantisationBox& box);

// The deformed point of a patch at barycentrics.
using PointOfPatch = std::function<DeformedPoint(size_t, const std::array<double, 3>&)>;

class Definition {
 public:
  // Evaluates the points of `patches`: by DirectFfd, or by `deformation` where it is given. Keeps references to the plan and
  // the control points, of which the tolerances follow.
  Definition(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
             NormalMode normals, std::vector<uint32_t> patches,
             const PointOfPatch& deformation = nullptr);

  // Compares `points` of the patches, in their order. kInternal names the first point whose deviation
  // exceeds the pipeline's tolerance.
  [[nodiscard]] absl::Status Check(Pipeline pipeline, std::span<const ViewPoint> points,
                                   RoundingTolerance rounding = {}) const;

 private:
  DirectFfd::SurfacePoint PointAt(const PointOfPatch& deformation, size_t patch,
                                  const std::array<double, 3>& barycentrics) const;
  double NormalTolerance(Pipeline pipeline, size_t at) const;

  const DeformPlan& plan_;
  const DirectFfd direct_;
  const NormalMode normals_;
  const DirectFfd::Normal kind_;
  const std::vector<uint32_t> patches_;
  std::vector<std::array<double, 3>> barycentrics_;
  std::vector<DirectFfd::SurfacePoint> points_;
  std::vector<double> patch_diagonals_;
  double scale_ = 0;  // D, in world units
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_DEFINITION_H_
