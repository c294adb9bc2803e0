// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/octahedral.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/base/limits.h"
#include "draco/compression/attributes/normal_compression_utils.h"

namespace latticed {
namespace {

OctahedralNormal QuantiseByDraco(Vec3f n, const draco::OctahedronToolBox& box) {
  const float vector[3] = {n.x, n.y, n.z};
  OctahedralNormal result;
  box.FloatVectorToQuantizedOctahedralCoords(vector, &result.s, &result.t);
  return result;
}

class OctahedralBits : public ::testing::TestWithParam<int> {
 protected:
  OctahedralBits() { box_.SetQuantizationBits(GetParam()); }
  draco::OctahedronToolBox box_;
};
INSTANTIATE_TEST_SUITE_P(All, OctahedralBits,
                         ::testing::Range(limits::kMinNormalBits, limits::kMaxNormalBits + 1));

TEST_P(OctahedralBits, EveryCellSurvivesDracoAndUs) {
  const int bits = GetParam();
  const int32_t top = OctahedralMax(bits);
  ASSERT_EQ(top, box_.max_value());

  int64_t wrong = 0;
  for (int32_t s = 0; s <= top; ++s) {
    for (int32_t t = 0; t <= top; ++t) {
      const Vec3f n = DequantiseNormal({s, t}, bits);
      float theirs[3];
      box_.QuantizedOctahedralCoordsToUnitVector(s, t, theirs);
      const OctahedralNormal expected = CanonicaliseOctahedral({s, t}, bits);
      wrong += n != Vec3f{theirs[0], theirs[1], theirs[2]};
      wrong += QuantiseByDraco(n, box_) != expected;
      wrong += QuantiseNormal(n, bits) != expected;
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST_P(OctahedralBits, RandomDirectionsRoundAsDracoDoes) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::normal_distribution<float> component;
  for (int i = 0; i < 100'000; ++i) {
    const Vec3f n{component(random), component(random), component(random)};
    ASSERT_EQ(QuantiseNormal(n, GetParam()), QuantiseByDraco(n, box_)) << "seed " << kSeed;
  }
}

TEST_P(OctahedralBits, ErrorIsWithinACell) {
  // A cell is 2 / top wide on the octahedron. The octahedron's faces stretch by at most 3 onto the
  // sphere, at their centres, at distance 1/sqrt(3). The error is half a cell in each of two coordinates.
  const double bound = 3.0 * std::sqrt(2.0) / OctahedralMax(GetParam());
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> component;
  for (int i = 0; i < 10'000; ++i) {
    const Vec3d n{component(random), component(random), component(random)};
    const Vec3d unit = n / Norm(n);
    const Vec3d back =
        ToDouble(DequantiseNormal(QuantiseNormal(ToFloat(unit), GetParam()), GetParam()));
    ASSERT_LE(Norm(back - unit), bound) << "seed " << kSeed;
    ASSERT_NEAR(Norm(back), 1.0, 1e-6);
  }
}

TEST(Octahedral, ZeroAndNotFiniteMapToPlusX) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const OctahedralNormal plus_x{127, 127};
  EXPECT_EQ(QuantiseNormal({1, 0, 0}, 8), plus_x);
  EXPECT_EQ(QuantiseNormal({0, 0, 0}, 8), plus_x);
  EXPECT_EQ(QuantiseNormal({nan, 0, 0}, 8), plus_x);
  EXPECT_EQ(QuantiseNormal({0, infinity, 0}, 8), plus_x);
}

TEST(Octahedral, AxesByHand) {
  EXPECT_EQ(QuantiseNormal({0, 2, 0}, 8), (OctahedralNormal{254, 127}));
  EXPECT_EQ(QuantiseNormal({0, -2, 0}, 8), (OctahedralNormal{0, 127}));
  EXPECT_EQ(QuantiseNormal({0, 0, 3}, 8), (OctahedralNormal{127, 254}));
  EXPECT_EQ(QuantiseNormal({0, 0, -3}, 8), (OctahedralNormal{127, 0}));
  EXPECT_EQ(QuantiseNormal({-1, 0, 0}, 8), (OctahedralNormal{254, 254}));
}

}  // namespace
}  // namespace latticed
