// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/tolerance/tolerance_checks.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "core/adaptive/edge_levels.h"

namespace latticed::testing {

const AdaptivePattern& PatternOf(uint16_t code) {
  return AdaptivePattern::Get(*PatternKey::FromCode(code));
}

size_t CountCracksBetween(const DeformPlan& plan, std::span<const Vec3d> control_points,
                          std::span<const uint16_t> codes, std::span<const ViewPoint> points) {
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  using Place = std::tuple<uint32_t, bool, size_t>;
  std::map<Place, Vec3d> corners, inner;
  std::map<uint32_t, size_t> segments;
  size_t cracks = 0, first = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const Patch& patch = plan.patches[p];
    const AdaptivePattern& pattern = PatternOf(codes[p]);
    const bool outside = patch.box == plan.outside_box();
    const auto apart = [&](uint32_t seam) {
      return seam != kNoIndex && !attached[seam] && outside;
    };
    const auto compare = [&](std::map<Place, Vec3d>& known, const Place& place, size_t point) {
      const Vec3d position = points[first + point].position;
      cracks += known.try_emplace(place, position).first->second != position;
    };
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t v = patch.vertex[i], e = patch.edge[i];
      const auto& along = pattern.edge_points[i];
      cracks += segments.try_emplace(e, along.size()).first->second != along.size();
      compare(corners, {v, apart(plan.vertices[v].seam), 0}, along[0]);
      for (size_t k = 1; k + 1 < along.size(); ++k) {
        const size_t place = patch.edge_reversed[i] ? along.size() - 1 - k : k;
        compare(inner, {e, apart(plan.edges[e].seam), place}, along[k]);
      }
    }
    first += pattern.points.size();
  }
  return cracks;
}

double LargestDistance(const DeformPlan& plan, std::span<const Vec3d> control_points,
                       std::span<const uint16_t> codes, std::span<const ViewPoint> points,
                       std::mt19937& random) {
  const DirectFfd definition(plan, control_points);
  std::uniform_real_distribution<double> uniform(0, 1);
  double largest = 0;
  size_t first = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const AdaptivePattern& pattern = PatternOf(codes[p]);
    for (const auto& triangle : pattern.triangles) {
      double x = uniform(random), y = uniform(random);
      if (x + y > 1) x = 1 - x, y = 1 - y;
      const double weight[3] = {1 - x - y, x, y};
      Vec3d chord;
      std::array<double, 3> at{};
      for (size_t c = 0; c < 3; ++c) {
        chord += weight[c] * points[first + triangle[c]].position;
        for (size_t a = 0; a < 3; ++a) {
          at[a] += weight[c] * pattern.points[triangle[c]][a] / pattern.denominator;
        }
      }
      largest = std::max(largest, Norm(definition.EvaluatePosition(p, at).position - chord));
    }
    first += pattern.points.size();
  }
  return largest;
}

void ExpectPointsOfTheDefinition(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                 const ViewSpec& spec, const QuantisationBox& box,
                                 std::span<const uint16_t> codes,
                                 std::span<const ViewPoint> points) {
  const DirectFfd definition(plan, control_points);
  const auto kind =
      spec.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  const int bits = spec.format == VertexFormat::kQuantised ? spec.position_bits : 0;
  const double rounding = RoundingOf(spec, box).normal;
  size_t i = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const AdaptivePattern& pattern = PatternOf(codes[p]);
    const double steepness = plan.is_weighted() ? Norm(plan.PatchWeightGradient(p)) : 0;
    const double of_kappa = kFusedNormal + kFusedPosition * box.range * steepness;
    for (size_t k = 0; k < pattern.points.size(); ++k, ++i) {
      std::array<double, 3> at{};
      for (size_t a = 0; a < 3; ++a) {
        at[a] = static_cast<double>(pattern.points[k][a]) / pattern.denominator;
      }
      const auto exact = definition.Evaluate(p, at, kind);
      ASSERT_LE(Norm(points[i].position - exact.position), PointError(box, bits))
          << "patch " << p << ", point " << k;
      ASSERT_NEAR(Norm(points[i].normal), 1, kUnitTolerance);
      if (exact.kappa > kMostKappa) continue;
      ASSERT_LE(Angle(points[i].normal, exact.normal), of_kappa * exact.kappa + rounding)
          << "patch " << p << ", point " << k;
    }
  }
  EXPECT_EQ(i, points.size());
}

}  // namespace latticed::testing
