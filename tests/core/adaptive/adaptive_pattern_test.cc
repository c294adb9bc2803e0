// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/adaptive_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

using Index = std::pair<int, int>;
using PointList = std::vector<std::array<uint16_t, 3>>;

// Every triple of levels, in both patterns.
std::vector<PatternKey> AllKeys() {
  std::vector<PatternKey> keys;
  for (uint16_t code = 0; code < 1 << kPatternCodeBits; ++code) {
    if (const auto key = PatternKey::FromCode(code)) keys.push_back(*key);
  }
  return keys;
}

std::string Name(const PatternKey& key) {
  return std::to_string(key.levels[0]) + "," + std::to_string(key.levels[1]) + "," +
         std::to_string(key.levels[2]) + (key.sparse ? " sparse" : "");
}

TEST(PatternKey, CodesNameThe432PatternsAndNothingElse) {
  const std::vector<PatternKey> keys = AllKeys();

  ASSERT_EQ(keys.size(), 2u * 6 * 6 * 6);
  for (const PatternKey& key : keys) EXPECT_EQ(PatternKey::FromCode(key.Code()), key);
  EXPECT_EQ((PatternKey{.levels = {1, 2, 5}, .sparse = true}.Code()), 1 + 2 * 8 + 5 * 64 + 512);
  EXPECT_FALSE(PatternKey::FromCode(6));       // level 6
  EXPECT_FALSE(PatternKey::FromCode(7 << 6));  // level 7 of edge 2
  EXPECT_FALSE(PatternKey::FromCode(uint16_t{1024})) << "an unknown bit";
}

// Edge 1 is split at (0, 1/2, 1/2). The side from there to corner 0 weighs 1/2 + 4/4 + 1/2 = 2, so it is split at
// (1/2, 1/4, 1/4). The sides from there to corners 1 and 2 weigh 3/8 + 3/4 + 1/8 = 5/4, and are split once more.
TEST(AdaptivePattern, OneSplitEdgeByHand) {
  const AdaptivePattern& p = AdaptivePattern::Get({.levels = {0, 1, 0}});

  EXPECT_EQ(p.denominator, 8);
  EXPECT_EQ(
      p.points,
      (PointList{{8, 0, 0}, {4, 2, 2}, {2, 5, 1}, {0, 8, 0}, {0, 4, 4}, {2, 1, 5}, {0, 0, 8}}));
  EXPECT_EQ(
      p.triangles,
      (PointList{
          {0, 5, 6}, {0, 1, 5}, {0, 2, 1}, {0, 3, 2}, {3, 4, 2}, {2, 4, 1}, {1, 4, 5}, {4, 6, 5}}));
  EXPECT_EQ(p.edge_points[0], (std::vector<uint16_t>{0, 3}));
  EXPECT_EQ(p.edge_points[1], (std::vector<uint16_t>{3, 4, 6}));
  EXPECT_EQ(p.edge_points[2], (std::vector<uint16_t>{6, 0}));
}

// In the sparser pattern the side from corner 0 weighs 1/2 - 4/4 + 1/2 = 0.
TEST(AdaptivePattern, OneSplitEdgeSparserByHand) {
  const AdaptivePattern& p = AdaptivePattern::Get({.levels = {0, 1, 0}, .sparse = true});

  EXPECT_EQ(p.denominator, 2);
  EXPECT_EQ(p.points, (PointList{{2, 0, 0}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}));
  EXPECT_EQ(p.triangles, (PointList{{0, 2, 3}, {0, 1, 2}}));
}

// Edges 1 and 2 are split. Both diagonals of the rest weigh 1/2 - 4/4 + 4/2 = 3/2. On this tie the diagonal from corner
// 0 is taken, the greater of corners 0 and 1. It is split as well.
TEST(AdaptivePattern, TwoSplitEdgesSparserByHand) {
  const AdaptivePattern& p = AdaptivePattern::Get({.levels = {0, 1, 1}, .sparse = true});

  EXPECT_EQ(p.denominator, 4);
  EXPECT_EQ(p.points,
            (PointList{{4, 0, 0}, {2, 1, 1}, {0, 4, 0}, {0, 2, 2}, {2, 0, 2}, {0, 0, 4}}));
  EXPECT_EQ(p.triangles, (PointList{{0, 1, 4}, {0, 2, 1}, {2, 3, 1}, {1, 3, 4}, {4, 3, 5}}));
}

TEST(AdaptivePattern, EqualLevelsAreTheUniformPattern) {
  for (uint8_t level = 0; level <= limits::kMaxEdgeLevel; ++level) {
    const TessellationPattern& uniform = TessellationPattern::Get(1 << level);
    for (const bool sparse : {false, true}) {
      const AdaptivePattern& p =
          AdaptivePattern::Get({.levels = {level, level, level}, .sparse = sparse});

      EXPECT_EQ(p.denominator, uniform.segments);
      EXPECT_TRUE(std::equal(
          p.points.begin(), p.points.end(), uniform.points.begin(), uniform.points.end(),
          [](const auto& a, const auto& b) { return std::equal(a.begin(), a.end(), b.begin()); }));
      EXPECT_EQ(p.triangles, uniform.triangles) << "level " << int{level};
      EXPECT_EQ(p.edge_points, uniform.edge_points);
    }
  }
}

// Twice the area of a triangle of the pattern, in units of the grid.
int64_t DoubleArea(const AdaptivePattern& p, const std::array<uint16_t, 3>& t) {
  const auto &a = p.points[t[0]], &b = p.points[t[1]], &c = p.points[t[2]];
  return int64_t{b[1] - a[1]} * (c[2] - a[2]) - int64_t{b[2] - a[2]} * (c[1] - a[1]);
}

// The triangles tile the patch with its winding, and meet corner to corner.
TEST(AdaptivePattern, EveryPatternConforms) {
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    SCOPED_TRACE(Name(key));

    ASSERT_EQ(std::set(p.points.begin(), p.points.end()).size(), p.points.size());
    for (const auto& point : p.points) ASSERT_EQ(point[0] + point[1] + point[2], p.denominator);
    int64_t area = 0;
    std::set<Index> directed;
    for (const auto& t : p.triangles) {
      ASSERT_GT(DoubleArea(p, t), 0);
      area += DoubleArea(p, t);
      for (size_t s = 0; s < 3; ++s) ASSERT_TRUE(directed.insert({t[s], t[(s + 1) % 3]}).second);
    }
    EXPECT_EQ(area, int64_t{p.denominator} * p.denominator);
    std::set<Index> rim;
    for (const Index& side : directed) {
      if (!directed.contains({side.second, side.first})) rim.insert(side);
    }
    std::set<Index> edges;
    for (const auto& edge : p.edge_points) {
      for (size_t k = 1; k < edge.size(); ++k) edges.insert({edge[k - 1], edge[k]});
    }
    EXPECT_EQ(rim, edges);
  }
}

TEST(AdaptivePattern, EdgesHaveSegmentsOfEqualLength) {
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    for (size_t e = 0; e < 3; ++e) {
      const int segments = 1 << key.levels[e];
      ASSERT_EQ(p.edge_points[e].size(), static_cast<size_t>(segments) + 1) << Name(key);
      for (int k = 0; k <= segments; ++k) {
        const auto& point = p.points[p.edge_points[e][static_cast<size_t>(k)]];
        ASSERT_EQ(point[(e + 1) % 3] * segments, k * p.denominator) << Name(key);
        ASSERT_EQ(point[(e + 2) % 3], 0) << Name(key);
      }
    }
  }
}

TEST(AdaptivePattern, DenominatorsAreInLowestTerms) {
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    if (p.denominator == 1) continue;
    EXPECT_TRUE(std::any_of(p.points.begin(), p.points.end(), [](const auto& point) {
      return (point[0] | point[1] | point[2]) % 2 == 1;
    })) << Name(key);
  }
}

TEST(AdaptivePattern, NoSideIsLongerThanItsRuleAllows) {
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    for (const auto& t : p.triangles) {
      for (size_t s = 0; s < 3; ++s) {
        std::array<double, 3> d;
        for (size_t a = 0; a < 3; ++a) {
          d[a] = double(p.points[t[(s + 1) % 3]][a] - p.points[t[s]][a]) / p.denominator;
        }
        double weight = 0;
        for (size_t e = 0; e < 3; ++e) {
          const double product = d[e] * d[(e + 1) % 3];
          weight += (key.sparse ? -product : std::abs(product)) * std::exp2(2 * key.levels[e]);
        }
        ASSERT_LE(weight, 1) << Name(key);
      }
    }
  }
}

// Clients may keep patterns by their code, so the rule must not change. Any other rule gives other sums.
TEST(AdaptivePattern, SizesOfAllPatterns) {
  std::array<size_t, 2> sum{}, most{};
  size_t most_triangles = 0;
  std::array<int, 2> denominator{};
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    sum[key.sparse] += p.points.size();
    most[key.sparse] = std::max(most[key.sparse], p.points.size());
    denominator[key.sparse] = std::max(denominator[key.sparse], p.denominator);
    most_triangles = std::max(most_triangles, p.triangles.size());
    EXPECT_LE(p.longest.size(), 33u) << Name(key);
    if (key.sparse) {
      EXPECT_LE(p.points.size(), AdaptivePattern::Get({.levels = key.levels}).points.size());
    }
  }
  EXPECT_EQ(sum, (std::array<size_t, 2>{82'569, 18'960}));
  EXPECT_EQ(most, (std::array<size_t, 2>{kMaxPatternPoints, 681}));
  EXPECT_EQ(most_triangles, size_t{kMaxPatternTriangles});
  EXPECT_LE(kMaxPatternPoints * limits::kPatchesPerChunk, limits::kMaxChunkPoints);
  EXPECT_EQ(denominator, (std::array<int, 2>{4'096, 64}));
}

// Steps along a row are the sides of small triangles. Steps between rows are few.
TEST(AdaptivePattern, ConsecutivePointsAreNear) {
  double sum = 0;
  size_t steps = 0;
  for (const PatternKey& key : AllKeys()) {
    const AdaptivePattern& p = AdaptivePattern::Get(key);
    for (size_t i = 1; i < p.points.size(); ++i, ++steps) {
      for (size_t a = 0; a < 3; ++a) {
        sum += std::abs(p.points[i][a] - p.points[i - 1][a]) / double(p.denominator);
      }
    }
  }
  EXPECT_LT(sum / double(steps), 0.1);
}

}  // namespace
}  // namespace latticed
