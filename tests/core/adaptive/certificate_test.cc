// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/certificate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/adaptive/edge_levels.h"

namespace latticed {
namespace {

constexpr uint32_t kCertificateSeed = 5;

TEST(LinearError, IsTheLargestValueOfLemmaOne) {
  constexpr int kGrid = 100;
  std::mt19937 random(kCertificateSeed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const double m01 = uniform(random), m12 = uniform(random),
                 m20 = trial % 5 == 0 ? 0 : uniform(random);
    double largest = 0;
    for (int i = 0; i <= kGrid; ++i) {
      for (int j = 0; j <= kGrid - i; ++j) {
        const double b0 = double(i) / kGrid, b1 = double(j) / kGrid, b2 = 1 - b0 - b1;
        largest = std::max(largest, (b0 * b1 * m01 + b1 * b2 * m12 + b2 * b0 * m20) / 2);
      }
    }

    const double error = LinearError(m01, m12, m20);

    EXPECT_GE(error, largest * (1 - 1e-12)) << "seed " << kCertificateSeed;
    EXPECT_LE(error, largest + 1e-4);  // the grid misses the maximum by half a cell
    EXPECT_LE(error, std::max({m01, m12, m20}) / 6 * (1 + 1e-12));
    EXPECT_DOUBLE_EQ(LinearError(m12, m20, m01), error);
    EXPECT_DOUBLE_EQ(LinearError(m12, m01, m20), error);
  }
}

TEST(LinearError, ByHand) {
  EXPECT_DOUBLE_EQ(LinearError(6.0, 6.0, 6.0), 1);  // equilateral: R^2 = M / 3
  EXPECT_DOUBLE_EQ(LinearError(8.0, 4.0, 4.0), 1);  // a right angle
  EXPECT_DOUBLE_EQ(LinearError(0.0, 8.0, 1.0), 1);  // one side curves much more than the others
  EXPECT_EQ(LinearError(0.0, 0.0, 0.0), 0);
  // Sides 5, 5, 6 have R = 25 / 8.
  EXPECT_FLOAT_EQ(LinearError(25.0f, 36.0f, 25.0f), 625.0f / 128);
}

// Second derivatives of a random quadratic patch, by the bilinear form of each component.
struct QuadraticPatch {
  Vec3d along_01, along_02, both;  // e01 e01, e02 e02, e01 e02
  explicit QuadraticPatch(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto draw = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
    along_01 = draw();
    along_02 = draw();
    both = draw();
  }
  // d and e are differences of barycentrics.
  Vec3d Second(const std::array<double, 3>& d, const std::array<double, 3>& e) const {
    return d[1] * e[1] * along_01 + d[2] * e[2] * along_02 + (d[1] * e[2] + d[2] * e[1]) * both;
  }
  CurvatureBounds<double> Bounds() const {
    const std::array<double, 3> edge[3] = {{-1, 1, 0}, {0, -1, 1}, {1, 0, -1}};
    CurvatureBounds<double> bounds;
    for (int e = 0; e < 3; ++e) {
      bounds.edge[e] = Norm(Second(edge[e], edge[e]));
      bounds.mixed[e] = Norm(Second(edge[e], edge[(e + 2) % 3]));
    }
    return bounds;
  }
};

TEST(SideCurvature, ContainsTheDerivativeAlongAnySide) {
  std::mt19937 random(kCertificateSeed);
  std::uniform_int_distribution<int> coordinate(-8, 8);
  double largest_share = 0;
  for (int trial = 0; trial < 2'000; ++trial) {
    const QuadraticPatch patch(random);
    std::array<double, 3> d{double(coordinate(random)), double(coordinate(random)), 0};
    d[2] = -d[0] - d[1];
    const double side[3] = {std::abs(d[0]), std::abs(d[1]), std::abs(d[2])};

    const double bound = SideCurvature(side, patch.Bounds());

    const double exact = Norm(patch.Second(d, d));
    EXPECT_GE(bound, exact * (1 - 1e-12)) << "seed " << kCertificateSeed;
    if (d[0] * d[1] * d[2] != 0) largest_share = std::max(largest_share, exact / bound);
  }
  EXPECT_GT(largest_share, 0.95);
}

TEST(SideCurvature, OfAnEdgeIsItsOwn) {
  const CurvatureBounds<double> bounds{.edge = {1, 2, 3}, .mixed = {10, 10, 10}};
  const double sides[3][3] = {{0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
  for (int e = 0; e < 3; ++e) EXPECT_DOUBLE_EQ(SideCurvature(sides[e], bounds), 0.25 * (e + 1));
}

double ErrorOfAllTriangles(const AdaptivePattern& p, const CurvatureBounds<double>& m) {
  double largest = 0;
  for (const auto& t : p.triangles) {
    double curvature[3];
    for (size_t s = 0; s < 3; ++s) {
      double side[3];
      for (size_t a = 0; a < 3; ++a) {
        side[a] = std::abs(p.points[t[(s + 1) % 3]][a] - p.points[t[s]][a]) / double(p.denominator);
      }
      curvature[s] = SideCurvature(side, m);
    }
    largest = std::max(largest, LinearError(curvature[0], curvature[1], curvature[2]));
  }
  return largest;
}

TEST(PatternError, TheLongestTrianglesDecide) {
  std::mt19937 random(kCertificateSeed);
  for (int trial = 0; trial < 1'000; ++trial) {
    std::uniform_int_distribution<int> level(0, limits::kMaxEdgeLevel);
    PatternKey key{.sparse = trial % 2 == 0};
    for (uint8_t& l : key.levels) l = static_cast<uint8_t>(level(random));
    const AdaptivePattern& pattern = AdaptivePattern::Get(key);
    const CurvatureBounds<double> bounds = QuadraticPatch(random).Bounds();

    const double all = ErrorOfAllTriangles(pattern, bounds);

    EXPECT_NEAR(PatternError(pattern, bounds), all, 1e-12 * all) << "trial " << trial;
  }
}

// The levels alone guarantee the tolerance, whatever the mixed derivatives are.
TEST(PatternError, DensePatternsMeetTheToleranceOfTheirLevels) {
  constexpr double kTolerance = 1e-3;
  for (uint16_t code = 0; code < 512; ++code) {
    const auto key = PatternKey::FromCode(code);
    if (!key) continue;
    CurvatureBounds<double> bounds;
    for (size_t e = 0; e < 3; ++e) {
      bounds.edge[e] = 6 * kTolerance * std::exp2(2 * key->levels[e]);
      bounds.mixed[e] = std::numeric_limits<double>::infinity();
      EXPECT_EQ(EdgeLevel(bounds.edge[e], kTolerance), key->levels[e]);
    }

    EXPECT_LE(PatternError(AdaptivePattern::Get(*key), bounds), kTolerance * (1 + 1e-12)) << code;
  }
}

TEST(ChoosePattern, TakesTheSparserOneOnlyWhereItPasses) {
  // A fold along the direction from corner 0 to the middle of edge 1: only edge 1 is curved, by 24, and so two segments
  // do.
  CurvatureBounds<double> bounds{.edge = {6, 24, 6}, .mixed = {6, 12, 12}};

  EXPECT_TRUE(ChoosePattern({0, 1, 0}, bounds, 1).pattern.key.sparse);
  EXPECT_DOUBLE_EQ(ChoosePattern({0, 1, 0}, bounds, 1).error, 1);
  EXPECT_FALSE(ChoosePattern({0, 1, 0}, bounds, 0.99).pattern.key.sparse);
  bounds.mixed[0] = 20;  // the side from corner 0 to the middle of edge 1 may curve now
  EXPECT_FALSE(ChoosePattern({0, 1, 0}, bounds, 1).pattern.key.sparse);
  EXPECT_FALSE(ChoosePattern({2, 2, 2}, {}, 1).pattern.key.sparse);  // the same pattern
}

TEST(EdgeLevel, IsTheLeastThatSuffices) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(EdgeLevel(0.0, 1.0), 0);
  EXPECT_EQ(EdgeLevel(6.0, 1.0), 0);
  EXPECT_EQ(EdgeLevel(6.001, 1.0), 1);
  EXPECT_EQ(EdgeLevel(24.0f, 1.0f), 1);
  EXPECT_EQ(EdgeLevel(24.001f, 1.0f), 2);
  EXPECT_EQ(EdgeLevel(6.0 * 1'024, 1.0), 5);
  EXPECT_EQ(EdgeLevel(1e9, 1.0), 5);
  EXPECT_EQ(EdgeLevel(kInfinity, 1.0), 5);
  EXPECT_EQ(EdgeLevel(kNotANumber, 1.0), 5);
  EXPECT_EQ(EdgeLevel(kNotANumber, kInfinity), 0);
  EXPECT_EQ(
      EdgeLevel(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()),
      0);
}

TEST(LeastPositionBits, LeavesAThirdForCurvature) {
  const QuantisationBox box{.range = 4};

  // sqrt(3) times 3e-7 * 4 is 2.1e-6; sqrt(3) / 2 times 4 / 4095 is 8.459e-4, and at 16 bits 5.286e-5.
  EXPECT_NEAR(PointError(box, 12), 8.480e-4, 5e-8);
  EXPECT_NEAR(PointError(box, 0), 2.078e-6, 5e-10);
  EXPECT_EQ(LeastPositionBits(1.273e-3, box), 12);
  EXPECT_EQ(LeastPositionBits(1.271e-3, box), 13);
  EXPECT_EQ(LeastPositionBits(1, box), 8);
  EXPECT_EQ(LeastPositionBits(8.25e-5, box), 16);
  EXPECT_EQ(LeastPositionBits(8.23e-5, box), std::nullopt);
  EXPECT_NEAR(CurvatureTolerance(1.5e-3, box, 12), 6.520e-4, 5e-8);
  EXPECT_NEAR(CurvatureTolerance(1e-6, box, 12), 4.240e-4, 5e-8);  // half of what the grid takes
}

}  // namespace
}  // namespace latticed
