// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The quantisation box: exact numbers, margins, and when it changes.
#include "core/ffd/plan/quantisation_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace latticed {
namespace {

constexpr uint32_t kBoxSeed = 7;

Bounds Cube(Vec3d lower, double edge) {
  Bounds bounds;
  bounds.Extend(lower);
  bounds.Extend(lower + Vec3d{edge, edge, edge});
  return bounds;
}

TEST(QuantisationBox, HoldsItsBoundsWithMarginOnAnExactGrid) {
  SCOPED_TRACE(kBoxSeed);
  std::mt19937 generator(kBoxSeed);
  std::uniform_real_distribution<double> exponent(-20, 20), unit(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const double size = std::exp2(exponent(generator));
    const Vec3d at{unit(generator), unit(generator), unit(generator)};
    const Bounds bounds = Cube(1000 * size * at, size);
    const QuantisationBox box = FitQuantisationBox(bounds, 3);

    EXPECT_EQ(box.id, 3u);
    EXPECT_TRUE(box.Contains(bounds));
    int power = 0;
    EXPECT_EQ(std::frexp(box.range, &power), 0.5) << "a power of two";
    EXPECT_LE(size, 0.75 * box.range);
    EXPECT_GT(size, 0.3 * box.range) << "no larger than it must be";
    for (int axis = 0; axis < 3; ++axis) {
      const double cells = box.origin[axis] / (box.range / 64);
      EXPECT_EQ(cells, std::round(cells));
    }
  }
}

TEST(QuantisationBox, HoldsAPointAndBoundsFarFromTheOrigin) {
  const Bounds point = Cube({5, 5, 5}, 0);
  EXPECT_TRUE(FitQuantisationBox(point, 1).Contains(point));
  const Bounds far = Cube({1e12, -1e12, 3}, 1e-3);
  EXPECT_TRUE(FitQuantisationBox(far, 1).Contains(far));
}

TEST(QuantisationBox, StaysWhileItFits) {
  const QuantisationBox box = FitQuantisationBox(Cube({0, 0, 0}, 1), 1);
  EXPECT_FALSE(NextQuantisationBox(box, Cube({0.1, 0.1, 0.1}, 0.9), false));
}

TEST(QuantisationBox, GrowsWhenLeftEvenDuringAGesture) {
  const QuantisationBox box = FitQuantisationBox(Cube({0, 0, 0}, 1), 1);
  const Bounds larger = Cube({0, 0, 0}, 3);
  const auto next = NextQuantisationBox(box, larger, true);
  ASSERT_TRUE(next.has_value());
  EXPECT_EQ(next->id, 2u);
  EXPECT_GT(next->range, box.range);
  EXPECT_TRUE(next->Contains(larger));
}

TEST(QuantisationBox, ShrinksBelowAQuarterButNotDuringAGesture) {
  const QuantisationBox box = FitQuantisationBox(Cube({0, 0, 0}, 1), 1);  // range 2
  const Bounds small = Cube({0.4, 0.4, 0.4}, 0.2);
  EXPECT_FALSE(NextQuantisationBox(box, small, true));
  const auto next = NextQuantisationBox(box, small, false);
  ASSERT_TRUE(next.has_value());
  EXPECT_LT(next->range, box.range);
  EXPECT_TRUE(next->Contains(small));
}

}  // namespace
}  // namespace latticed
