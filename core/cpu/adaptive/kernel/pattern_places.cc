// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/kernel/pattern_places.h"

#include <array>
#include <memory>
#include <mutex>

#include "core/cpu/adaptive/kernel/adaptive_kernel.h"

namespace latticed {

using fused::PlaceCode;

PatternPlaces::PatternPlaces(const AdaptivePattern& pattern)
    : code(pattern.points.size(), PlaceCode(0, 1, 2)),
      along(pattern.points.size()),
      up(pattern.points.size()) {
  const auto denominator = static_cast<float>(pattern.denominator);
  for (size_t i = 0; i < pattern.points.size(); ++i) {
    const auto& steps = pattern.points[i];
    up[i] = static_cast<float>(steps[2]) / denominator;
    along[i] = static_cast<float>(steps[1]) / denominator - 0.5f + 0.5f * up[i];
  }
  for (int e = 0; e < 3; ++e) {
    const auto& points = pattern.edge_points[static_cast<size_t>(e)];
    const auto segments = static_cast<float>(points.size() - 1);
    for (size_t k = 1; k + 1 < points.size(); ++k) {
      code[points[k]] = PlaceCode(e, (e + 1) % 3, e);
      along[points[k]] = static_cast<float>(k) / segments - 0.5f;
      up[points[k]] = 0;
    }
    code[points[0]] = PlaceCode(e, e, e);
    along[points[0]] = up[points[0]] = 0;
  }
}

const PatternPlaces& PatternPlaces::Get(uint16_t code) {
  constexpr size_t kCodes = size_t{1} << kPatternCodeBits;
  static std::array<std::once_flag, kCodes> once;
  // Never destroyed: threads may still use them when the program ends.
  static auto& tables = *new std::array<std::unique_ptr<const PatternPlaces>, kCodes>;
  std::call_once(once[code], [&] {
    tables[code] =
        std::make_unique<const PatternPlaces>(AdaptivePattern::Get(*PatternKey::FromCode(code)));
  });
  return *tables[code];
}

}  // namespace latticed
