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

PatternKey ChoosePattern(const std::array<uint8_t, 3>& levels, const CurvatureBounds<double>& m,
                         double tolerance) {
  const PatternKey sparse{.levels = levels, .sparse = true}, dense{.levels = levels};
  const AdaptivePattern& sparser = AdaptivePattern::Get(sparse);
  if (sparser.points.size() >= AdaptivePattern::Get(dense).points.size()) return dense;
  return PatternError(sparser, m) <= tolerance ? sparse : dense;
}

}  // namespace latticed
