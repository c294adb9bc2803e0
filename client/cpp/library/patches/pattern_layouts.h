// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// PatchSurface.patterns as layouts, which AssembleMesh and CarryAttributes (client/cpp/library/mesh.h) take.
//
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATTERN_LAYOUTS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATTERN_LAYOUTS_H_

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "client/cpp/library/patch_layout.h"
#include "core/adaptive/adaptive_pattern.h"

namespace latticed::client {

class PatternLayouts {
 public:
  // By patch. They refer to this object. `codes`: those of PatchEvaluator.
  [[nodiscard]] std::vector<PatchLayout> Of(std::span<const uint16_t> codes) {
    std::vector<PatchLayout> layouts;
    layouts.reserve(codes.size());
    for (const uint16_t code : codes) {
      const Held& held = Get(code);
      layouts.push_back({held.denominator, held.points, held.triangles});
    }
    return layouts;
  }

 private:
  struct Held {
    double denominator = 1;
    std::vector<uint32_t> points, triangles;
  };

  const Held& Get(uint16_t code) {
    const auto [found, added] = held_.try_emplace(code);
    Held& held = found->second;
    if (!added) return held;
    const AdaptivePattern& pattern = AdaptivePattern::Get(*PatternKey::FromCode(code));
    held.denominator = pattern.denominator;
    for (const auto& p : pattern.points) held.points.insert(held.points.end(), p.begin(), p.end());
    for (const auto& t : pattern.triangles) {
      held.triangles.insert(held.triangles.end(), t.begin(), t.end());
    }
    return held;
  }

  std::map<uint16_t, Held> held_;  // by code
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATTERN_LAYOUTS_H_
