// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tolerances.h"

#include <cmath>

namespace latticed::testing {
namespace {

// Row sums of |Bqu inv(B)| at 10 segments, n = 3..9 (exact inverse): what differentiating the
// interpolant does to the rounding of its samples.
constexpr std::array<double, 7> kDerivativeRowSum{29, 69, 148, 303, 608, 1200, 2380};
// Samples, matrix and sums are each rounded to float; 8 half-units in the last place cover them.
constexpr double kProductRounding = 8 * 0x1p-24;
// What the result itself is rounded by.
constexpr double kResultRounding = 2 * 0x1p-24;

// The error of each derivative is the row sum times the extent of what was sampled.
double GemmNormalBound(const DeformPlan& plan, const DirectFfd& direct, const NormalPlace& place) {
  const Patch& p = plan.patches[place.patch];
  const std::array<Vec3d, 3>& j = direct.EvaluatePosition(place.patch, place.barycentrics).jacobian;
  const auto carry = [&](Vec3d d) { return d.x * j[0] + d.y * j[1] + d.z * j[2]; };
  const Vec3d corner = plan.vertices[p.vertex[0]].world;
  const Vec3d e1 = plan.vertices[p.vertex[1]].world - corner;
  const Vec3d e2 = plan.vertices[p.vertex[2]].world - corner;
  const Vec3d f = direct.RestFacetNormal(place.patch);
  const Vec3d pu = carry(e1), pv = carry(e2), pf = carry(f);
  const auto n = static_cast<size_t>(plan.structure.patch_degree());
  // Twice the points' bounds, for segments that skip the bulge.
  const double extent = 2 * place.patch_diagonal;
  const double error = kProductRounding * kDerivativeRowSum[n - 3] * extent;
  if (place.kind == DirectFfd::Normal::kFacet) {
    return error * (Norm(pu) + Norm(pv)) / Norm(Cross(pu, pv));
  }
  // Pf is interpolated, not differentiated: its error is that of a position, with its own extent.
  const double error_f = kProductRounding * 32 * (Norm(pf) + CofactorNorm(j));
  const Vec3d normal = direct.RestSmoothNormal(place.patch, place.barycentrics);
  const double by_f = Dot(normal, f), by_1 = Dot(normal, e1), by_2 = Dot(normal, e2);
  const Vec3d sum = by_f * Cross(pu, pv) + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu);
  const double turned = std::abs(by_f) * error * (Norm(pu) + Norm(pv)) +
                        std::abs(by_1) * (error * Norm(pf) + error_f * Norm(pv)) +
                        std::abs(by_2) * (error * Norm(pf) + error_f * Norm(pu));
  return turned / Norm(sum);
}

}  // namespace

double NormalTolerance(Pipeline pipeline, const DeformPlan& plan, const DirectFfd& direct,
                       const NormalPlace& place) {
  if (pipeline == Pipeline::kFused) return kFusedNormal * place.kappa;
  return kResultRounding + GemmNormalBound(plan, direct, place);
}

}  // namespace latticed::testing
