// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/adaptive_reference.h"

#include <algorithm>
#include <utility>

#include "core/adaptive/certificate.h"
#include "core/adaptive/composed_patch.h"
#include "core/adaptive/edge_levels.h"

namespace latticed {
namespace {

// The bounds do not depend on the shear. With this one, x = t = 0 is on the median.
constexpr double kShear = 0.5;

template <int kDegree>
CurvatureBounds<double> BoundOfDegree(const double* const* p, int degree) {
  if constexpr (kDegree < kMostWeightedDegree) {
    if (degree > kDegree) return BoundOfDegree<kDegree + 1>(p, degree);
  }
  return BoundCurvature<kDegree, double>(p, kShear);
}

}  // namespace

AdaptiveReference::AdaptiveReference(std::shared_ptr<const DeformPlan> plan)
    : plan_(plan), basis_(std::move(plan)) {}

AdaptiveReference::BoxCoefficients AdaptiveReference::Polynomial(
    uint32_t box, std::span<const Vec3d> control_points) const {
  return plan_->is_weighted() ? basis_.OffsetPolynomial(box, control_points)
                              : basis_.Polynomial(box, control_points);
}

CurvatureBounds<double> AdaptiveReference::BoundPatch(size_t p,
                                                      std::span<const Vec3d> polynomial) const {
  const Patch& patch = plan_->patches[p];
  std::array<Vec3d, 3> corner;
  for (size_t c = 0; c < 3; ++c) {
    corner[c] = basis_.Local(patch.box, plan_->vertices[patch.vertex[c]]);
  }
  const Vec3d along = corner[1] - corner[0], across = corner[2] - corner[0] - kShear * along;
  const Vec3d centre = corner[0] + 0.5 * along + 0.5 * across;
  double map[3][3];
  for (int a = 0; a < 3; ++a) {
    map[a][0] = centre[a];
    map[a][1] = along[a];
    map[a][2] = across[a];
  }
  double weight[3] = {1, 0, 0};  // at x = t = 0, and its derivatives
  if (plan_->is_weighted()) {
    const std::array<double, 3> of_corner = plan_->CornerWeights(p);
    weight[1] = of_corner[1] - of_corner[0];
    weight[2] = of_corner[2] - of_corner[0] - kShear * weight[1];
    weight[0] = of_corner[0] + 0.5 * weight[1] + 0.5 * weight[2];
  }
  const double* coefficients[3];
  PatchPolynomial<double> composed[3];
  for (int component = 0; component < 3; ++component) {
    double c[BoxBasis::kMostTerms];
    for (size_t k = 0; k < polynomial.size(); ++k) c[k] = polynomial[k][component];
    composed[component] = ComposePatch(c, basis_.degree(), map);
    if (plan_->is_weighted()) composed[component].MultiplyLinear(weight);
    coefficients[component] = composed[component].value;
  }
  return BoundOfDegree<3 * limits::kMinDegree>(coefficients, composed[0].degree);
}

std::vector<CurvatureBounds<double>> AdaptiveReference::Bounds(
    std::span<const Vec3d> control_points) const {
  std::vector<CurvatureBounds<double>> bounds(plan_->patches.size());
  for (uint32_t box = 0; box < plan_->outside_box(); ++box) {
    const uint32_t first = plan_->box_patches[box], last = plan_->box_patches[box + 1];
    if (first == last) continue;
    const BoxCoefficients polynomial = Polynomial(box, control_points);
    for (uint32_t p = first; p < last; ++p) bounds[p] = BoundPatch(p, polynomial);
  }
  return bounds;
}

AdaptiveTessellation AdaptiveReference::Tessellate(std::span<const CurvatureBounds<double>> bounds,
                                                   double tolerance) const {
  std::vector<double> largest(plan_->edges.size());
  for (size_t p = 0; p < bounds.size(); ++p) {
    for (size_t e = 0; e < 3; ++e) {
      double& edge = largest[plan_->patches[p].edge[e]];
      edge = std::max(edge, bounds[p].edge[e]);
    }
  }
  AdaptiveTessellation result;
  for (const double curvature : largest) {
    result.edge_levels.push_back(EdgeLevel(curvature, tolerance));
  }
  for (size_t p = 0; p < bounds.size(); ++p) {
    std::array<uint8_t, 3> levels;
    for (size_t e = 0; e < 3; ++e) levels[e] = result.edge_levels[plan_->patches[p].edge[e]];
    const PatternChoice choice = ChoosePattern(levels, bounds[p], tolerance);
    result.patterns.push_back(choice.pattern.key);
    result.errors.push_back(choice.error);
    result.largest_error = std::max(result.largest_error, choice.error);
  }
  return result;
}

}  // namespace latticed
