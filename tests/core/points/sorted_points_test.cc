// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/sorted_points.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "tests/core/points/point_fixture.h"

namespace latticed {
namespace {

constexpr uint32_t kSortSeed = 8;

TEST(SortedPoints, EveryPointIsInTheRunOfItsBoxInTheOrderGiven) {
  RandomVectors random(kSortSeed);
  CpuArena arena(2);
  const LatticeStructure s = ObliqueStructure({2, 1, 3}, {3, 2, 2});
  const std::vector<Vec3d> world = random.Around(s, 5'000);

  const SortedPoints points(s, world, {}, arena);

  ASSERT_EQ(points.size(), world.size());
  EXPECT_EQ(points.boxes().count(), 3u * 2 * 2);
  std::vector<int> seen(world.size());
  size_t next = 0;
  for (const SortedPoints::Run& run : points.runs()) {
    EXPECT_EQ(run.first, next);
    for (size_t i = 0; i < run.count; ++i) {
      const uint32_t number = points.order()[run.first + i];
      ++seen[number];
      EXPECT_EQ(points.WorldAt(run.first + i), world[number]);
      const auto place = FindVolumePlace(s, world[number]);
      ASSERT_TRUE(place.has_value());
      EXPECT_EQ(points.boxes().BoxOf(place->span), run.box);
      EXPECT_TRUE(i == 0 || number > points.order()[run.first + i - 1]);
    }
    next = run.first + run.count;
  }
  EXPECT_EQ(next, points.inside());
  for (size_t place = points.inside(); place < points.size(); ++place) {
    ++seen[points.order()[place]];
    EXPECT_FALSE(FindVolumePlace(s, points.WorldAt(place)).has_value());
  }
  EXPECT_EQ(std::accumulate(seen.begin(), seen.end(), 0), 5'000);
  EXPECT_EQ(*std::ranges::max_element(seen), 1);
}

TEST(SortedPoints, ABoxWithManyPointsHasSeveralRuns) {
  CpuArena arena(1);
  const LatticeStructure s = ObliqueStructure({2, 2, 2}, {1, 1, 1});
  const std::vector<Vec3d> world(2 * SortedPoints::kRunPoints + 5, s.frame.origin);

  const SortedPoints points(s, world, {}, arena);

  ASSERT_EQ(points.runs().size(), 3u);
  EXPECT_EQ(points.runs()[2].count, 5u);
}

TEST(SortedPoints, ResortedHasThePointsOfAnotherStructure) {
  RandomVectors random(kSortSeed + 1);
  CpuArena arena(2);
  const LatticeStructure before = ObliqueStructure({2, 2, 2}, {1, 1, 1});
  const LatticeStructure after = ObliqueStructure({3, 1, 2}, {4, 5, 2});
  const std::vector<Vec3d> world = random.Around(before, 3'000), normals = random.Units(3'000);

  std::vector<PointWeight> weights(3'000);
  for (PointWeight& weight : weights) weight = {random.Next().x, random.Next()};

  const SortedPoints resorted =
      SortedPoints(before, world, normals, arena, weights).Resorted(after, arena);

  const SortedPoints expected(after, world, normals, arena, weights);
  EXPECT_EQ(resorted.order(), expected.order());
  EXPECT_EQ(resorted.inside(), expected.inside());
  for (size_t place = 0; place < resorted.size(); ++place) {
    ASSERT_EQ(resorted.WorldAt(place), expected.WorldAt(place));
    ASSERT_EQ(resorted.NormalAt(place), expected.NormalAt(place));
    ASSERT_EQ(resorted.weights()[place].weight, weights[resorted.order()[place]].weight);
    ASSERT_EQ(resorted.weights()[place].gradient, weights[resorted.order()[place]].gradient);
  }
}

TEST(SortedPoints, CountsItsMemory) {
  RandomVectors random(kSortSeed + 2);
  CpuArena arena(1);
  const LatticeStructure s = ObliqueStructure({2, 2, 2}, {1, 1, 1});
  const std::vector<Vec3d> world = random.Around(s, 1'000);
  EXPECT_EQ(SortedPoints::BytesFor(1'000, false, false), 28'000u);
  EXPECT_EQ(SortedPoints::BytesFor(1'000, true, false), 52'000u);
  EXPECT_EQ(SortedPoints::BytesFor(1'000, true, true), 84'000u);
  EXPECT_GE(SortedPoints(s, world, world, arena).MemoryBytes(), 52'000u);
  EXPECT_LE(SortedPoints(s, world, world, arena).MemoryBytes(), 52'200u);
  const std::vector<PointWeight> weights(1'000);
  EXPECT_GE(SortedPoints(s, world, world, arena, weights).MemoryBytes(), 84'000u);
}

}  // namespace
}  // namespace latticed
