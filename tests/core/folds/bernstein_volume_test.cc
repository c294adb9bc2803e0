// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/bernstein_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace latticed {
namespace {

constexpr double kRounding = 1e-14;

BernsteinVolume RandomVolume(std::array<size_t, 3> count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  BernsteinVolume volume{.count = count};
  for (size_t i = 0; i < volume.size(); ++i) volume.coefficients[i] = uniform(random);
  return volume;
}

// The definition.
double Sum(const BernsteinVolume& v, Vec3d l) {
  const auto b = [](size_t d, size_t i, double t) {
    double value = 1;
    for (size_t k = 0; k < i; ++k) {
      value *= static_cast<double>(d - k) / static_cast<double>(k + 1) * t;
    }
    return value * std::pow(1 - t, static_cast<double>(d - i));
  };
  double sum = 0;
  for (size_t k = 0; k < v.count[2]; ++k) {
    for (size_t j = 0; j < v.count[1]; ++j) {
      for (size_t i = 0; i < v.count[0]; ++i) {
        sum += v.coefficients[i + v.count[0] * (j + v.count[1] * k)] * b(v.count[0] - 1, i, l.x) *
               b(v.count[1] - 1, j, l.y) * b(v.count[2] - 1, k, l.z);
      }
    }
  }
  return sum;
}

TEST(BernsteinVolume, ValueMatchesDefinition) {
  const BernsteinVolume volume = RandomVolume({9, 3, 6}, 1);
  for (const Vec3d l : {Vec3d{0.3, 0.7, 0.1}, Vec3d{0, 1, 0.5}, Vec3d{1, 1, 1}}) {
    EXPECT_NEAR(volume.Value(l), Sum(volume, l), kRounding);
  }
}

TEST(BernsteinVolume, CornersAreValues) {
  const BernsteinVolume volume = RandomVolume({3, 6, 9}, 2);
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3d l{double(corner & 1u), double((corner >> 1) & 1u), double(corner >> 2)};
    EXPECT_EQ(volume.Corner(corner), volume.Value(l));
  }
}

TEST(BernsteinVolume, HalvesAreThePolynomial) {
  for (const size_t axis : {0u, 1u, 2u}) {
    const BernsteinVolume volume = RandomVolume({6, 9, 3}, 3);
    BernsteinVolume lower = volume, upper;
    lower.Halve(axis, upper);
    for (const Vec3d l : {Vec3d{0.2, 0.9, 0.6}, Vec3d{0, 0, 0}, Vec3d{1, 1, 1}}) {
      Vec3d below = l, above = l;
      below[static_cast<int>(axis)] = 0.5 * l[static_cast<int>(axis)];
      above[static_cast<int>(axis)] = 0.5 + 0.5 * l[static_cast<int>(axis)];
      EXPECT_NEAR(lower.Value(l), volume.Value(below), kRounding);
      EXPECT_NEAR(upper.Value(l), volume.Value(above), kRounding);
    }
  }
}

TEST(BernsteinVolume, LeastIsNoMoreThanAnyValue) {
  const BernsteinVolume volume = RandomVolume({9, 9, 9}, 4);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 10; ++i) least = std::min(least, volume.Value({0.1 * i, 0.5, 0.1 * i}));
  EXPECT_LE(volume.Least(), least);
  EXPECT_GE(volume.Least(), -1);
}

TEST(BernsteinVolume, LeastIsNanIfACoefficientIs) {
  BernsteinVolume volume = RandomVolume({3, 3, 3}, 5);
  volume.coefficients[13] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(volume.Least()));
}

TEST(BernsteinVolume, SteepestAxisHasTheLargestSlope) {
  for (const size_t axis : {0u, 1u, 2u}) {
    BernsteinVolume volume{.count = {3, 3, 3}};
    for (size_t i = 0; i < volume.size(); ++i) {
      const std::array<size_t, 3> at{i % 3, i / 3 % 3, i / 9};
      volume.coefficients[i] = static_cast<double>(at[0] + at[1] + at[2] + 5 * at[axis]);
    }
    EXPECT_EQ(volume.SteepestAxis(), axis);
  }
}

}  // namespace
}  // namespace latticed
