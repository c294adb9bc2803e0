// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/trimming/trimmed_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace latticed::bench {
namespace {

constexpr int kSegments = 10;

// Twice the area, positive where c is left of a -> b.
double Turn(TrimmedPoint a, TrimmedPoint b, TrimmedPoint c) {
  return (b.s - a.s) * (c.t - a.t) - (c.s - a.s) * (b.t - a.t);
}

double Area(const std::vector<TrimmedPoint>& polygon) {
  double twice = 0;
  for (size_t i = 1; i + 1 < polygon.size(); ++i) {
    twice += Turn(polygon[0], polygon[i], polygon[i + 1]);
  }
  return twice / 2;
}

double Area(const TrimmedGrid& grid) {
  double twice = 0;
  for (const auto& [a, b, c] : grid.triangles) {
    const double turn = Turn(grid.points[a], grid.points[b], grid.points[c]);
    EXPECT_GE(turn, -1e-15) << "a triangle lies on its face";
    twice += turn;
  }
  return twice / 2;
}

// Corners on an ellipse, which fills the square as a polygon fills its rectangle.
std::vector<TrimmedPoint> RandomPolygon(size_t corners, std::mt19937& random) {
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::vector<double> angles(corners);
  for (double& a : angles) a = angle(random);
  std::sort(angles.begin(), angles.end());
  std::vector<TrimmedPoint> polygon;
  polygon.reserve(corners);
  for (const double a : angles) polygon.push_back({std::cos(a), std::sin(a)});
  const auto [left, right] = std::minmax_element(
      polygon.begin(), polygon.end(), [](const auto& a, const auto& b) { return a.s < b.s; });
  const auto [low, high] = std::minmax_element(
      polygon.begin(), polygon.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  const TrimmedPoint from{left->s, low->t}, size{right->s - left->s, high->t - low->t};
  for (TrimmedPoint& p : polygon) p = {(p.s - from.s) / size.s, (p.t - from.t) / size.t};
  return polygon;
}

// Sides of triangles that no other triangle has, each from its triangle's winding.
std::set<std::pair<uint16_t, uint16_t>> Boundary(const TrimmedGrid& grid) {
  std::set<std::pair<uint16_t, uint16_t>> sides;
  for (const auto& triangle : grid.triangles) {
    for (size_t e = 0; e < 3; ++e) {
      const std::pair side{triangle[e], triangle[(e + 1) % 3]};
      if (sides.erase({side.second, side.first}) > 0) continue;
      EXPECT_TRUE(sides.insert(side).second) << "two triangles on one side of an edge";
    }
  }
  return sides;
}

bool OnASide(const std::vector<TrimmedPoint>& polygon, TrimmedPoint a, TrimmedPoint b) {
  for (size_t i = 0; i < polygon.size(); ++i) {
    const TrimmedPoint from = polygon[i], to = polygon[(i + 1) % polygon.size()];
    if (std::abs(Turn(from, to, a)) < 1e-12 && std::abs(Turn(from, to, b)) < 1e-12) return true;
  }
  return false;
}

TEST(TrimmedGridTest, TheSquareKeepsEveryCell) {
  const std::vector<TrimmedPoint> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

  const TrimmedGrid grid = TrimGrid(square, kSegments);

  EXPECT_EQ(grid.points.size(), 121u);
  EXPECT_EQ(grid.triangles.size(), 200u);
  EXPECT_NEAR(Area(grid), 1, 1e-14);
}

TEST(TrimmedGridTest, HalfOfTheSquareIsThePatternOfAPatch) {
  const std::vector<TrimmedPoint> half{{0, 0}, {1, 0}, {0, 1}};

  const TrimmedGrid grid = TrimGrid(half, kSegments);

  EXPECT_EQ(grid.points.size(), 66u);
  EXPECT_EQ(grid.triangles.size(), 100u);
  EXPECT_NEAR(Area(grid), 0.5, 1e-14);
}

TEST(TrimmedGridTest, PolygonsAreCoveredOnceWithoutGaps) {
  std::mt19937 random(20130102);
  for (size_t corners = 3; corners <= 9; ++corners) {
    for (int trial = 0; trial < 20; ++trial) {
      const std::vector<TrimmedPoint> polygon = RandomPolygon(corners, random);

      const TrimmedGrid grid = TrimGrid(polygon, kSegments);

      SCOPED_TRACE(testing::Message() << corners << " corners, trial " << trial);
      EXPECT_NEAR(Area(grid), Area(polygon), 1e-12);
      for (const auto& [a, b] : Boundary(grid)) {
        EXPECT_TRUE(OnASide(polygon, grid.points[a], grid.points[b]));
      }
      for (size_t i = 1; i < grid.points.size(); ++i) {
        const TrimmedPoint a = grid.points[i - 1], b = grid.points[i];
        EXPECT_LT(std::pair(a.t, a.s), std::pair(b.t, b.s)) << "sorted, and each once";
      }
    }
  }
}

TEST(TrimmedGridTest, APolygonWithoutAreaHasPointsOnOneLine) {
  const std::vector<TrimmedPoint> flat{{0, 0}, {0.55, 0}, {1, 0}};

  const TrimmedGrid grid = TrimGrid(flat, kSegments);

  EXPECT_EQ(grid.points.size(), 12u);  // eleven of the grid, and a corner
  EXPECT_EQ(Area(grid), 0);
}

}  // namespace
}  // namespace latticed::bench
