// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/flat_patterns.h"

#include <gtest/gtest.h>

#include <array>

#include "core/adaptive/adaptive_pattern.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

using kernels::PatternHead;
using kernels::PatternPlace;

// m + along d + up (c - m), in barycentrics.
std::array<double, 3> BarycentricsOf(PatternPlace place) {
  const auto kind = static_cast<size_t>(place.Kind());
  const size_t a = kind % 3, b = kind < 3 ? a : (a + 1) % 3, c = kind == 6 ? 2 : a;
  const double along = double{place.Along()}, up = double{place.Up()};
  std::array<double, 3> at{};
  at[a] += (1 - up) / 2 - along;
  at[b] += (1 - up) / 2 + along;
  at[c] += up;
  return at;
}

TEST(FlatPatternsTest, HoldsThePlacesAndTrianglesOfEachPattern) {
  const FlatPatterns& flat = FlatPatterns::Get();
  ASSERT_EQ(flat.heads.size(), 1024u);
  size_t patterns = 0, places = 0, triangles = 0;
  for (uint16_t code = 0; code < 1024; ++code) {
    SCOPED_TRACE(fmt::format("code {}", code));
    const PatternHead& head = flat.heads[code];
    const auto key = PatternKey::FromCode(code);
    if (!key.has_value()) {
      EXPECT_EQ(head.points, 0);
      continue;
    }
    ++patterns;
    const AdaptivePattern& pattern = AdaptivePattern::Get(*key);
    ASSERT_EQ(head.points, pattern.points.size());
    ASSERT_EQ(head.triangles, pattern.longest.size());
    for (size_t i = 0; i < pattern.points.size(); ++i, ++places) {
      const std::array<double, 3> at = BarycentricsOf(flat.places.at(head.first_place + i));
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(at[c] * pattern.denominator, pattern.points[i][c]) << "point " << i;
      }
    }
    for (size_t t = 0; t < pattern.longest.size(); ++t, ++triangles) {
      for (size_t s = 0; s < 3; ++s) {
        for (size_t a = 0; a < 3; ++a) {
          ASSERT_EQ(flat.triangles.at(head.first_triangle + t).side[s][a],
                    pattern.longest[t][s][a]);
        }
      }
    }
  }
  EXPECT_EQ(patterns, 432u);
  EXPECT_EQ(places, flat.places.size());
  EXPECT_EQ(triangles, flat.triangles.size());
}

TEST(FlatPatternsTest, CornersAndEdgesAreNamedAsSuch) {
  const FlatPatterns& flat = FlatPatterns::Get();
  const PatternKey key{.levels = {1, 2, 5}};
  const AdaptivePattern& pattern = AdaptivePattern::Get(key);
  std::vector<int> kinds(pattern.points.size(), PatternPlace::kInside);
  for (size_t e = 0; e < 3; ++e) {
    const auto& points = pattern.edge_points[e];
    kinds[points[0]] = static_cast<int>(e);
    for (size_t k = 1; k + 1 < points.size(); ++k) kinds[points[k]] = 3 + static_cast<int>(e);
  }
  for (size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(flat.places[flat.heads[key.Code()].first_place + i].Kind(), kinds[i]) << i;
  }
}

}  // namespace
}  // namespace latticed::testing
