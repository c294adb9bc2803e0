// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/edge_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace latticed {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(EdgeBound, TakesTheLeastByte) {
  constexpr double kUnit = 1;
  EXPECT_EQ(EdgeBoundByte(0, kUnit), 0);
  EXPECT_EQ(EdgeBoundByte(0.999, kUnit), 0);
  EXPECT_EQ(EdgeBoundByte(1.001, kUnit), 1);
  EXPECT_EQ(EdgeBoundByte(1.4142, kUnit), 1);
  EXPECT_EQ(EdgeBoundByte(1.4143, kUnit), 2);
  EXPECT_EQ(EdgeBoundByte(2, kUnit), 2);
  EXPECT_EQ(EdgeBoundByte(2.0001, kUnit), 3);
  EXPECT_EQ(EdgeBoundByte(1024, kUnit), 20);
  EXPECT_EQ(EdgeBoundByte(0x1p127, kUnit), 254);
}

TEST(EdgeBound, KnowsNothingOfWhatIsNoNumberOrTooLarge) {
  EXPECT_EQ(EdgeBoundByte(std::nan(""), 1), 255);
  EXPECT_EQ(EdgeBoundByte(kInfinity, 1), 255);
  EXPECT_EQ(EdgeBoundByte(0x1.000001p127, 1), 255);
  EXPECT_EQ(EdgeBound(255, 1), kInfinity);
}

TEST(EdgeBound, HoldsAndIsTightAtEveryScale) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-40, 40);
  for (const double diagonal : {1e-15, 1e-6, 1.0, 1e6, 1e15}) {
    const double unit = CurvatureUnit({{0, 0, 0}, {diagonal, 0, 0}});
    for (int i = 0; i < 10'000; ++i) {
      const double curvature = diagonal * std::exp2(exponent(random));
      const uint8_t byte = EdgeBoundByte(curvature, unit);
      ASSERT_GE(EdgeBound(byte, unit), curvature);
      if (byte == 0) continue;
      ASSERT_LT(EdgeBound(static_cast<uint8_t>(byte - 1), unit), curvature + 0x1p-62) << diagonal;
    }
  }
}

TEST(EdgeBound, EveryByteIsTheLeastForItsOwnBound) {
  for (int byte = 0; byte < 255; ++byte) {
    const double bound = EdgeBound(static_cast<uint8_t>(byte), 1);
    EXPECT_EQ(EdgeBoundByte(bound * (1 - 1e-12) - 0x1p-62, 1), byte);
    EXPECT_EQ(EdgeBoundByte(bound * (1 + 1e-12), 1), byte + 1);  // 255 after 254
  }
}

TEST(EdgeBound, UnitIsAPowerOfTwoAtTheDiagonal) {
  EXPECT_EQ(CurvatureUnit({{0, 0, 0}, {1, 0, 0}}), 0x1p-32);
  EXPECT_EQ(CurvatureUnit({{0, 0, 0}, {3, 4, 0}}), 0x1p-29);  // 5 is at most 8
  EXPECT_EQ(CurvatureUnit({{2, 2, 2}, {2, 2, 10}}), 0x1p-29);
  EXPECT_EQ(CurvatureUnit({{-1e15, -1e15, -1e15}, {1e15, 1e15, 1e15}}), 0x1p20);
  EXPECT_EQ(CurvatureUnit({{0, 0, 0}, {1e-15, 0, 0}}), 0x1p-81);
  EXPECT_EQ(CurvatureUnit({{0, 0, 0}, {1e-40, 0, 0}}), 0x1p-126);
}

TEST(EdgeBound, AllowsForBoundsThatVanishInFloat32) {
  const double unit = CurvatureUnit({{0, 0, 0}, {1e-15, 0, 0}});
  const double bound = EdgeBound(EdgeBoundByte(0, unit), unit);
  EXPECT_GE(bound, 0x1p-62);
  EXPECT_LT(bound, 6 * 1e-4 * 1e-15);  // level 0 at 1e-4 of the diagonal
}

}  // namespace
}  // namespace latticed
