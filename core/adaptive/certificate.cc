// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/certificate.h"

#include <algorithm>

namespace latticed {

double PatternError(const AdaptivePattern& pattern, const CurvatureBounds<double>& m) {
  double largest = 0;
  for (const PatternSides& sides : pattern.longest) {
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
