// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/trimming/parameter_rectangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace latticed::bench {
namespace {

constexpr Vec3d kUp{0, 0, 1};

void ExpectNear(Vec3d a, Vec3d b) { EXPECT_LT(Norm(a - b), 1e-12); }

// All three rectangles on a side have twice its area; the least perimeter is that on the side from
// (1, 3) to (0, 0): 2 (sqrt(10) + 12 / sqrt(10)).
TEST(ParameterRectangleTest, OfAnAcuteTriangleHasTheLeastPerimeterWhicheverCornerIsFirst) {
  std::array<Vec3d, 3> corners{Vec3d{0, 0, 0}, {4, 0, 0}, {1, 3, 0}};
  for (int first = 0; first < 3; ++first) {
    const ParameterRectangle rectangle = SmallestRectangle(corners, kUp);

    ExpectNear(rectangle.corner, {1, 3, 0});
    ExpectNear(rectangle.along, {-1, -3, 0});
    ExpectNear(rectangle.across, {3.6, -1.2, 0});
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
  }
}

TEST(ParameterRectangleTest, OfAnObtuseTriangleLiesOnItsLongestSide) {
  const std::array<Vec3d, 3> corners{Vec3d{3, 1, 0}, {0, 0, 0}, {10, 0, 0}};
  const ParameterRectangle rectangle = SmallestRectangle(corners, kUp);

  ExpectNear(rectangle.corner, {0, 0, 0});
  ExpectNear(rectangle.along, {10, 0, 0});
  ExpectNear(rectangle.across, {0, 1, 0});
  ASSERT_EQ(rectangle.polygon.size(), 3u);
  EXPECT_NEAR(rectangle.polygon[0].s, 0.3, 1e-12);
  EXPECT_NEAR(rectangle.polygon[0].t, 1, 1e-12);
}

TEST(ParameterRectangleTest, OfARectangleIsItself) {
  const double h = std::sqrt(0.5);
  const std::array<Vec3d, 4> corners{Vec3d{0, 0, 0}, {2 * h, 2 * h, 0}, {h, 3 * h, 0}, {-h, h, 0}};
  const ParameterRectangle rectangle = SmallestRectangle(corners, kUp);

  EXPECT_NEAR(Norm(Cross(rectangle.along, rectangle.across)), 2, 1e-12);
  for (const TrimmedPoint& point : rectangle.polygon) {
    EXPECT_NEAR(std::abs(point.s - 0.5), 0.5, 1e-12);
    EXPECT_NEAR(std::abs(point.t - 0.5), 0.5, 1e-12);
  }
}

TEST(ParameterRectangleTest, OfOnePointHasNoExtent) {
  const std::array<Vec3d, 3> corners{Vec3d{1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
  const ParameterRectangle rectangle = SmallestRectangle(corners, kUp);

  ExpectNear(rectangle.corner, {1, 2, 3});
  EXPECT_EQ(Norm(rectangle.along), 0);
  EXPECT_EQ(Norm(rectangle.across), 0);
  for (const TrimmedPoint& point : rectangle.polygon) EXPECT_EQ(point.s + point.t, 0);
}

}  // namespace
}  // namespace latticed::bench
