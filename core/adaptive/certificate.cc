// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/certificate.h"

#include <algorithm>

namespace latticed {
namespace {

// What SideCurvature is at most: the first of its four bounds.
double MostCurvature(const std::array<double, 3>& side, const CurvatureBounds<double>& m) {
  return side[0] * side[1] * m.edge[0] + side[1] * side[2] * m.edge[1] +
         side[2] * side[0] * m.edge[2];
}

}  // namespace

double PatternError(const AdaptivePattern& pattern, const CurvatureBounds<double>& m) {
  // LinearError is at most a sixth of its largest argument. With its rounding it is below this share.
  constexpr double kMostShare = (1 + 1e-6) / 6;
  double largest = 0;
  for (const PatternSides& sides : pattern.longest) {
    // Most triangles cannot have the largest error, which is seen at once.
    const double most = std::max(
        {MostCurvature(sides[0], m), MostCurvature(sides[1], m), MostCurvature(sides[2], m)});
    if (kMostShare * most <= largest) continue;
    largest = std::max(
        largest, LinearError(SideCurvature(sides[0].data(), m), SideCurvature(sides[1].data(), m),
                             SideCurvature(sides[2].data(), m)));
  }
  return largest;
}

PatternChoice ChoosePattern(const std::array<uint8_t, 3>& levels, const CurvatureBounds<double>& m,
                            double tolerance) {
  const AdaptivePattern& dense = AdaptivePattern::Get({.levels = levels});
  if (levels[0] != levels[1] || levels[1] != levels[2]) {  // else both patterns are the same
    const AdaptivePattern& sparse = AdaptivePattern::Get({.levels = levels, .sparse = true});
    if (sparse.points.size() < dense.points.size()) {
      const double error = PatternError(sparse, m);
      if (error <= tolerance) return {sparse, error};
    }
  }
  return {dense, PatternError(dense, m)};
}

}  // namespace latticed
