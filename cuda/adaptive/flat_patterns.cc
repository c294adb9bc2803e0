// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/flat_patterns.h"

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/pattern_split.h"

namespace latticed {
namespace {

using kernels::PatternPlace;
using kernels::PatternTriangle;

// Steps of `along` in a place, from 0 to 1.
constexpr int kAlongSteps = 2 * kSplitDenominator;

void AddPlaces(const AdaptivePattern& pattern, std::vector<PatternPlace>& places) {
  const size_t first = places.size();
  const int unit = kSplitDenominator / pattern.denominator;
  for (const auto& steps : pattern.points) {
    const int i1 = steps[1] * unit, i2 = steps[2] * unit;
    places.push_back(
        PatternPlace::Make(PatternPlace::kInside, 2 * i1 + i2 - kSplitDenominator, i2));
  }
  for (size_t e = 0; e < 3; ++e) {
    const auto& on_edge = pattern.edge_points[e];
    const int edge = static_cast<int>(e), segments = static_cast<int>(on_edge.size()) - 1;
    places[first + on_edge[0]] = PatternPlace::Make(edge, 0, 0);
    for (int k = 1; k < segments; ++k) {
      places[first + on_edge[static_cast<size_t>(k)]] =
          PatternPlace::Make(3 + edge, k * (kAlongSteps / segments) - kSplitDenominator, 0);
    }
  }
}

void AddTriangles(const AdaptivePattern& pattern, std::vector<PatternTriangle>& triangles) {
  for (const PatternSides& sides : pattern.longest) {
    PatternTriangle& triangle = triangles.emplace_back();
    for (size_t s = 0; s < 3; ++s) {
      for (size_t a = 0; a < 3; ++a) triangle.side[s][a] = static_cast<float>(sides[s][a]);
    }
  }
}

FlatPatterns MakeFlatPatterns() {
  constexpr uint16_t kCodes = uint16_t{1} << kPatternCodeBits;
  FlatPatterns flat;
  flat.heads.resize(kCodes);
  for (uint16_t code = 0; code < kCodes; ++code) {
    const auto key = PatternKey::FromCode(code);
    if (!key.has_value()) continue;
    const AdaptivePattern& pattern = AdaptivePattern::Get(*key);
    flat.heads[code] = {.first_place = static_cast<uint32_t>(flat.places.size()),
                        .first_triangle = static_cast<uint32_t>(flat.triangles.size()),
                        .points = static_cast<uint16_t>(pattern.points.size()),
                        .triangles = static_cast<uint16_t>(pattern.longest.size())};
    AddPlaces(pattern, flat.places);
    AddTriangles(pattern, flat.triangles);
  }
  return flat;
}

}  // namespace

const FlatPatterns& FlatPatterns::Get() {
  // Never destroyed: threads may still use them when the program ends.
  static const auto& patterns = *new FlatPatterns(MakeFlatPatterns());
  return patterns;
}

}  // namespace latticed
