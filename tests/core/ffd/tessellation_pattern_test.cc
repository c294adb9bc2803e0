// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/tessellation_pattern.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

#include "core/base/limits.h"

namespace latticed {
namespace {

TEST(TessellationPattern, TwoSegmentsByHand) {
  const TessellationPattern& p = TessellationPattern::Get(2);

  // Row 0 runs forward, row 1 backward, and row 2 is corner 2.
  const std::vector<std::array<uint8_t, 3>> points{{2, 0, 0}, {1, 1, 0}, {0, 2, 0},
                                                   {0, 1, 1}, {1, 0, 1}, {0, 0, 2}};
  const std::vector<std::array<uint16_t, 3>> triangles{{0, 1, 4}, {1, 3, 4}, {1, 2, 3}, {4, 3, 5}};
  EXPECT_EQ(p.points, points);
  EXPECT_EQ(p.triangles, triangles);
  EXPECT_EQ(p.edge_points[0], (std::vector<uint16_t>{0, 1, 2}));
  EXPECT_EQ(p.edge_points[1], (std::vector<uint16_t>{2, 3, 5}));
  EXPECT_EQ(p.edge_points[2], (std::vector<uint16_t>{5, 4, 0}));
}

TEST(TessellationPattern, EveryCountIsAFullTriangulation) {
  for (int s = limits::kMinSegments; s <= limits::kMaxSegments; ++s) {
    const TessellationPattern& p = TessellationPattern::Get(s);

    ASSERT_EQ(p.segments, s);
    ASSERT_EQ(p.points.size(), static_cast<size_t>((s + 1) * (s + 2) / 2));
    ASSERT_EQ(p.triangles.size(), static_cast<size_t>(s * s));
    std::set<std::array<uint8_t, 3>> distinct(p.points.begin(), p.points.end());
    EXPECT_EQ(distinct.size(), p.points.size());
    for (const auto& point : p.points) EXPECT_EQ(point[0] + point[1] + point[2], s);
    // Every directed edge occurs once, and only the rim is boundary: a manifold with one winding.
    std::map<std::pair<int, int>, int> directed;
    for (const auto& t : p.triangles) {
      const auto& a = p.points[t[0]];
      const auto& b = p.points[t[1]];
      const auto& c = p.points[t[2]];
      const int area = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
      EXPECT_EQ(area, 1) << "segments " << s;
      for (size_t e = 0; e < 3; ++e) ++directed[{t[e], t[(e + 1) % 3]}];
    }
    int rim = 0;
    for (const auto& [edge, count] : directed) {
      EXPECT_EQ(count, 1);
      rim += directed.count({edge.second, edge.first}) == 0;
    }
    EXPECT_EQ(rim, 3 * s);
  }
}

TEST(TessellationPattern, ConsecutivePointsAreNeighbours) {
  const TessellationPattern& p = TessellationPattern::Get(7);
  for (size_t i = 1; i < p.points.size(); ++i) {
    int distance = 0;
    for (size_t c = 0; c < 3; ++c) distance += std::abs(p.points[i][c] - p.points[i - 1][c]);
    EXPECT_EQ(distance, 2) << "point " << i;
  }
}

}  // namespace
}  // namespace latticed
