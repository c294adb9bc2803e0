// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A triangulation is right if every triangle has the polygon's winding and the areas add up to the
// polygon's area. Triangles that leave the polygon or overlap would add up to more.
#include "core/mesh/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/limits.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

using Triangles = std::vector<std::array<uint32_t, 3>>;

Triangles Triangulate(const std::vector<Vec3d>& polygon) {
  Triangles triangles = {{9, 9, 9}};  // must be replaced
  EXPECT_OK(TriangulatePolygon(polygon, &triangles));
  return triangles;
}

// Every edge of the polygon is used once, in its direction, and every diagonal once in each direction.
void ExpectCoversEveryEdge(size_t corners, const Triangles& triangles) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& t : triangles) {
    for (size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end());
  size_t unpaired = 0;
  for (const auto& [a, b] : edges) {
    if (std::binary_search(edges.begin(), edges.end(), std::pair(b, a))) continue;
    EXPECT_EQ((a + 1) % corners, b);
    ++unpaired;
  }
  EXPECT_EQ(unpaired, corners);
}

// Only for plane polygons.
void ExpectDivides(const std::vector<Vec3d>& polygon, double tolerance = 1e-12) {
  const Triangles triangles = Triangulate(polygon);

  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  ExpectCoversEveryEdge(polygon.size(), triangles);
  const Vec3d normal = NewellNormal(polygon);
  const double area = Norm(normal);
  double sum = 0;
  for (const auto& t : triangles) {
    const Vec3d n = Cross(polygon[t[1]] - polygon[t[0]], polygon[t[2]] - polygon[t[0]]);
    EXPECT_GE(Dot(n, normal) / area, -tolerance * area) << t[0] << ' ' << t[1] << ' ' << t[2];
    sum += Norm(n);
  }
  EXPECT_NEAR(sum, area, tolerance * area);
}

std::vector<Vec3d> Tilted(const std::vector<Vec3d>& flat, Vec3d origin = {}) {
  std::vector<Vec3d> tilted;
  for (Vec3d p : flat) {
    tilted.push_back(origin + p.x * Vec3d{0.36, 0.48, -0.8} + p.y * Vec3d{-0.8, 0.6, 0});
  }
  return tilted;
}

std::vector<Vec3d> Reversed(std::vector<Vec3d> polygon) {
  std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

// Starting at every corner, in both windings, flat and tilted.
void ExpectDividesFromEveryStart(std::vector<Vec3d> polygon) {
  for (size_t start = 0; start < polygon.size(); ++start) {
    ExpectDivides(polygon);
    ExpectDivides(Reversed(Tilted(polygon)));
    std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
  }
}

TEST(TriangulateTest, FewerThanThreeCornersGiveNothing) {
  EXPECT_TRUE(Triangulate({}).empty());
  EXPECT_TRUE(Triangulate({{0, 0, 0}, {1, 0, 0}}).empty());
}

TEST(TriangulateTest, TriangleKeepsItsWinding) {
  EXPECT_EQ(Triangulate({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}), (Triangles{{0, 1, 2}}));
}

TEST(TriangulateTest, QuadTakesTheShorterDiagonalThatDividesIt) {
  EXPECT_EQ(Triangulate({{0, 0, 0}, {3, -1, 0}, {6, 0, 0}, {3, 1, 0}}),
            (Triangles{{0, 1, 3}, {1, 2, 3}}));
  EXPECT_EQ(Triangulate({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}),
            (Triangles{{0, 1, 2}, {0, 2, 3}}));
  // An arrowhead, which only the diagonal from its reflex corner divides.
  ExpectDividesFromEveryStart({{0, 0, 0}, {4, 1, 0}, {0, 2, 0}, {1, 1, 0}});
}

TEST(TriangulateTest, ConcavePolygonsFromEveryStart) {
  const std::vector<std::vector<Vec3d>> polygons = {
      {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}},  // L
      {{0, 0, 0},
       {5, 0, 0},
       {5, 3, 0},
       {4, 3, 0},
       {4, 1, 0},
       {1, 1, 0},
       {1, 3, 0},
       {0, 3, 0}},  // U
      {{0, 0, 0},
       {7, 0, 0},
       {7, 3, 0},
       {6, .1, 0},
       {5, 3, 0},
       {4, .1, 0},
       {3, 3, 0},
       {2, .1, 0},
       {1, 3, 0}},  // comb
  };
  for (const auto& polygon : polygons) ExpectDividesFromEveryStart(polygon);
}

TEST(TriangulateTest, SpiralOfTwoHundredCorners) {
  constexpr int kArm = 100;
  std::vector<Vec3d> spiral;
  for (int i = 0; i < 2 * kArm; ++i) {
    const int step = i < kArm ? i : 2 * kArm - 1 - i;
    const double angle = 0.25 * step;
    const double radius = 1 + 0.1 * angle + (i < kArm ? 0.0 : 0.3);
    spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  ExpectDivides(spiral);
  ExpectDivides(Tilted(spiral));
}

TEST(TriangulateTest, PointsOnStraightEdgesMakeNoOverlap) {
  const std::vector<Vec3d> square = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 1, 0},
                                     {3, 3, 0}, {2, 3, 0}, {0, 3, 0}, {0, 2, 0}, {0, 1, 0}};
  ExpectDivides(square);
  ExpectDivides(Tilted(square));
  for (const auto& t : Triangulate(square)) {  // every triangle has an area
    EXPECT_GT(Norm(Cross(square[t[1]] - square[t[0]], square[t[2]] - square[t[0]])), 0.5);
  }
}

TEST(TriangulateTest, HoleBridgedByADoubledEdge) {
  // An outer square, a bridge from (0,0) to (1,1), the hole clockwise, and the bridge back.
  const std::vector<Vec3d> keyhole = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0},
                                      {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
  ExpectDividesFromEveryStart(keyhole);
}

TEST(TriangulateTest, RandomStarShapedPolygons) {
  constexpr uint32_t kSeed = 20141;
  SCOPED_TRACE(::testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> radius(0.2, 1.0);
  for (int round = 0; round < 500; ++round) {
    const int corners = 5 + round % 96;
    std::vector<Vec3d> star;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      const double r = radius(random);
      star.push_back({r * std::cos(angle), r * std::sin(angle), 0});
    }
    ExpectDivides(star);
    ExpectDivides(Tilted(star, {1e3, -1e3, 1e3}), 1e-9);  // 1,000 diagonals away
  }
}

TEST(TriangulateTest, CapOfTwentyThousandCorners) {
  constexpr int kCorners = 20'000;
  std::vector<Vec3d> cap;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    const double r = i % 4 < 2 ? 1.0 : 0.9;
    cap.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  ExpectDivides(cap, 1e-9);
}

// Its corners alternate between two circles.
std::vector<Vec3d> Star(int corners, double inner_radius) {
  std::vector<Vec3d> star;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    const double r = i % 2 == 0 ? 1.0 : inner_radius;
    star.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  return star;
}

// A zigzag band: every corner of the one side is close to a corner of the other.
std::vector<Vec3d> Zigzag(int corners) {
  std::vector<Vec3d> band;
  for (int i = 0; i < corners; ++i) {
    const bool upper = i >= corners / 2;
    const int step = upper ? corners - 1 - i : i;
    const double x = 4.0 * step / corners;
    band.push_back({x, (step % 2 == 0 ? 0.0 : 1.0) + (upper ? 0.6 / corners : 0.0), 0});
  }
  return band;
}

// Petals of three corners around one point, where a third of all corners are.
std::vector<Vec3d> Flower(int petals) {
  std::vector<Vec3d> flower;
  for (int i = 0; i < petals; ++i) {
    const double angle = 2 * std::numbers::pi * i / petals, wide = std::numbers::pi / petals;
    flower.push_back({0, 0, 0});
    flower.push_back({std::cos(angle), std::sin(angle), 0});
    flower.push_back({std::cos(angle + wide), std::sin(angle + wide), 0});
  }
  return flower;
}

// Each took minutes while every corner that is no ear was tried again after each ear.
TEST(TriangulateTest, ThinSpikesOfTheMostCornersTakeFewTestsEach) {
  constexpr int kCorners = limits::kMaxFaceCorners;
  for (const double inner_radius : {0.5, 0.1, 1e-3}) {
    ExpectDivides(Star(kCorners, inner_radius), 1e-9);
  }
  ExpectDivides(Zigzag(kCorners), 1e-9);
}

TEST(TriangulateTest, APolygonThatTakesTooLongIsRefused) {
  Triangles triangles;
  EXPECT_OK(TriangulatePolygon(Flower(1'000), &triangles));

  const absl::Status status = TriangulatePolygon(Flower(10'000), &triangles);

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(status.message().find("it takes too long to triangulate"), 0u) << status;
}

TEST(TriangulateTest, StopsWhenTold) {
  int asked = 0;
  const auto stop = [&asked] {
    return ++asked < 3 ? absl::OkStatus() : absl::CancelledError("nobody waits");
  };
  Triangles triangles;

  EXPECT_THAT(TriangulatePolygon(Flower(limits::kMaxFaceCorners / 3), &triangles, stop),
              StatusIs(absl::StatusCode::kCancelled));

  EXPECT_EQ(asked, 3);
}

TEST(TriangulateTest, DegeneratePolygonsStillGiveTwoLessThanCorners) {
  const std::vector<std::vector<Vec3d>> degenerate = {
      {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},                         // a point
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1.5, 0, 0}},            // a line
      {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},                         // a bow tie
      {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {1, 3, 0}, {1, -1, 0}},  // crosses itself
      {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}, {0, 1, 0}},   // doubled corners
      {{1e300, 0, 0}, {-1e300, 0, 0}, {0, 1e300, 0}, {0, 0, -1e300}, {1, 1, 1}},
      {{1e-310, 0, 0}, {0, 0, 0}, {0, 1e-310, 0}, {1e-310, 1e-310, 0}, {1e-310, 0, 0}},
  };
  for (const auto& polygon : degenerate) {
    const Triangles triangles = Triangulate(polygon);
    ASSERT_EQ(triangles.size(), polygon.size() - 2);
    ExpectCoversEveryEdge(polygon.size(), triangles);
  }
}

TEST(TriangulateTest, SkewPolygonCoversItsBoundary) {
  const std::vector<Vec3d> skew = {{0, 0, 0.1}, {2, 0, -0.1}, {2, 1, 0.2},
                                   {1, 1, 0},   {1, 2, -0.2}, {0, 2, 0}};
  const Triangles triangles = Triangulate(skew);
  ASSERT_EQ(triangles.size(), 4u);
  ExpectCoversEveryEdge(skew.size(), triangles);
}

TEST(TriangulateTest, NewellNormalIsTwiceTheVectorArea) {
  const Vec3d normal = NewellNormal(std::vector<Vec3d>{{5, 5, 1}, {7, 5, 1}, {7, 8, 1}, {5, 8, 1}});
  EXPECT_EQ(normal, (Vec3d{0, 0, 12}));
}

}  // namespace
}  // namespace latticed
