// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far from the definition in double (core/ffd/direct_ffd.h) the vertices of a pipeline may be;
// two backends or pipelines agree within the sum.
//
//   position  PositionTolerance() * D, D = max(diagonal of the deformed bounds, diagonal of the
//             control points that influence the mesh)
//   normal    in rad, where kappa <= kMostKappa. fused: kFusedNormal * kappa; GEMM: the rounding of
//             the products, carried to the cross product
//
// Threads  pure
#ifndef LATTICED_TESTS_SUPPORT_TOLERANCES_H_
#define LATTICED_TESTS_SUPPORT_TOLERANCES_H_

#include <array>
#include <cstddef>

#include "core/backend.h"
#include "core/ffd/direct_ffd.h"

namespace latticed::testing {

inline constexpr double kFusedPosition = 3e-7;
inline constexpr double kGemmPosition = 1e-6;
inline constexpr double kFusedNormal = 2e-5;
inline constexpr double kMostKappa = 100;

[[nodiscard]] constexpr double PositionTolerance(Pipeline pipeline) {
  return pipeline == Pipeline::kFused ? kFusedPosition : kGemmPosition;
}

// A point of a patch where a normal is compared.
struct NormalPlace {
  size_t patch = 0;
  std::array<double, 3> barycentrics{};
  DirectFfd::Normal kind = DirectFfd::Normal::kFacet;
  double kappa = 1;
  double patch_diagonal = 0;  // of the bounds of the patch's points
};
[[nodiscard]] double NormalTolerance(Pipeline pipeline, const DeformPlan& plan,
                                     const DirectFfd& direct, const NormalPlace& place);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_TOLERANCES_H_
