// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/quantise_vertices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "core/codec/octahedral.h"
#include "tests/support/instruction_sets.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 29;

// Directions of all kinds: random, on axes and diagonals of the octahedral square, at the edges
// between its cells, tiny and not finite.
std::vector<Vec3f> Directions(size_t count, int bits) {
  std::mt19937 random(kSeed);
  std::normal_distribution<float> component;
  const int32_t centre = OctahedralMax(bits) / 2;
  const auto grid = [&] {  // halves of a step
    return static_cast<float>(std::uniform_int_distribution(-2 * centre, 2 * centre)(random)) *
           0.5f;
  };
  const float odd[] = {0,
                       -0.0f,
                       1,
                       -1,
                       1e-7f,
                       std::numeric_limits<float>::quiet_NaN(),
                       std::numeric_limits<float>::infinity()};
  std::vector<Vec3f> directions;
  for (size_t i = 0; i < count; ++i) {
    if (i % 4 == 0) {
      directions.push_back({odd[random() % 7], odd[random() % 7], odd[random() % 7]});
    } else if (i % 4 == 1) {
      const float y = grid(), z = grid();
      directions.push_back({static_cast<float>(centre) - std::abs(y) - std::abs(z), y, z});
    } else {
      directions.push_back({component(random), component(random), component(random)});
    }
  }
  return directions;
}

int32_t At(const uint8_t* plane, size_t i, int bits) {
  uint16_t value = plane[i];
  if (bits > 8) std::memcpy(&value, plane + 2 * i, 2);
  return value;
}

TEST(QuantiseVertices, NormalsAreAsDefinedUnderEveryInstructionSet) {
  for (int bits = 6; bits <= 12; ++bits) {
    const std::vector<Vec3f> directions = Directions(20'003, bits);
    std::vector<float> values;
    for (const Vec3f n : directions) values.insert(values.end(), {1, 2, 3, n.x, n.y, n.z});
    std::vector<uint8_t> bytes(10 * directions.size());
    for (const int64_t target : Targets()) {
      const ChosenTarget chosen(target);
      const QuantisedVertices q = QuantiseVertices(
          {.point_count = directions.size(), .values = values.data(), .normal_bits = bits},
          bytes.data());
      for (size_t i = 0; i < directions.size(); ++i) {
        ASSERT_EQ((OctahedralNormal{At(q.s, i, bits), At(q.t, i, bits)}),
                  QuantiseNormal(directions[i], bits))
            << bits << " bits, direction " << i << ", seed " << kSeed;
      }
      ASSERT_EQ(q.z[directions.size() - 1], 3);
    }
  }
}

TEST(QuantiseVertices, PositionsRoundToTheGridAndStayOnIt) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> coordinate(-0.2f, 1.2f);
  constexpr size_t kPoints = 1003;
  std::vector<float> values(3 * kPoints);
  for (float& value : values) value = coordinate(random);
  values[0] = std::numeric_limits<float>::quiet_NaN();
  values[1] = std::numeric_limits<float>::infinity();
  values[2] = -1e30f;
  const FloatVertices vertices{.point_count = kPoints,
                               .values = values.data(),
                               .scale = {4095, 4095, 1000},
                               .offset = {0, 0.25f, 100},
                               .position_bits = 12};
  std::vector<uint8_t> bytes(10 * kPoints);
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    const QuantisedVertices q = QuantiseVertices(vertices, bytes.data());
    EXPECT_EQ(q.x[0], 0);
    EXPECT_EQ(q.y[0], 4095);
    EXPECT_EQ(q.z[0], 0);
    const uint16_t* planes[] = {q.x, q.y, q.z};
    for (size_t i = 1; i < kPoints; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        const float product = values[3 * i + c] * vertices.scale[c];
        const float grid = product + vertices.offset[c];
        ASSERT_EQ(planes[c][i], std::lrint(std::clamp(grid, 0.0f, 4095.0f))) << i;
      }
    }
  }
}

TEST(QuantiseVertices, PositionsHalfWayGoToTheEvenNeighbour) {
  constexpr size_t kPoints = 131;
  std::vector<float> values;
  for (size_t i = 0; i < kPoints; ++i) {
    const float half = static_cast<float>(i) + 0.5f;
    values.insert(values.end(), {half, std::nextafter(half, 0.0f), std::nextafter(half, 1e9f)});
  }
  values[0] = std::numeric_limits<float>::denorm_min();
  std::vector<uint8_t> bytes(10 * kPoints);
  for (const int64_t target : Targets()) {
    const ChosenTarget chosen(target);
    const QuantisedVertices q = QuantiseVertices(
        {.point_count = kPoints, .values = values.data(), .scale = {1, 1, 1}, .position_bits = 12},
        bytes.data());
    EXPECT_EQ(q.x[0], 0);
    for (size_t i = 1; i < kPoints; ++i) {
      ASSERT_EQ(q.x[i], i % 2 == 0 ? i : i + 1);
      ASSERT_EQ(q.y[i], i);
      ASSERT_EQ(q.z[i], i + 1);
    }
  }
}

}  // namespace
}  // namespace latticed::testing
