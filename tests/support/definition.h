// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of a view, compared with the definition in double (core/ffd/direct_ffd.h).
//
//   position  within PositionTolerance() * D, D = max(diagonal of the deformed points, diagonal of
//             the control points that influence the mesh)
//   normal    of length 1; in rad, where kappa <= kMostKappa: within kFusedNormal * kappa, or by the
//             rounding of the products (GEMM), carried to the cross product
//
// Two backends or pipelines agree within the sum.
//
// Threads  pure
#ifndef LATTICED_TESTS_SUPPORT_DEFINITION_H_
#define LATTICED_TESTS_SUPPORT_DEFINITION_H_

#include <array>
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
  Vec3d position;  // in the world
  Vec3d normal;    // as stored; zero without normals
};
// From the wire layout of a whole number of points.
[[nodiscard]] std::vector<ViewPoint> DecodePoints(const DeformPlan& plan, const ViewSpec& spec,
                                                  const QuantisationBox& box,
                                                  std::span<const uint8_t> bytes);

// What rounding to integers adds: half a step on each axis, and half a cell's diagonal, which the
// map from the octahedron to the sphere stretches by at most sqrt(3); cells on the rim name a
// direction twice. Zero for floats.
struct RoundingTolerance {
  double position = 0, normal = 0;
};
[[nodiscard]] RoundingTolerance RoundingOf(const ViewSpec& spec, const QuantisationBox& box);

class Definition {
 public:
  // Of some patches. Keeps references to the plan and the control points.
  Definition(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
             NormalMode normals, std::vector<uint32_t> patches);

  // Of the patches, in their order. kInternal with the first point that is farther from the
  // definition than the pipeline may be.
  [[nodiscard]] absl::Status Check(Pipeline pipeline, std::span<const ViewPoint> points,
                                   RoundingTolerance rounding = {}) const;

 private:
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
