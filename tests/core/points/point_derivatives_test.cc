// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for the host alone; tests/backend/points_test.cc has what holds for all backends.
#include "core/points/point_derivatives.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <vector>

#include "tests/core/points/point_fixture.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kDerivativeSeed = 26;
constexpr double kJitter = 0.2;  // of coordinates; the frame's edges are 2 to 4 long

TEST(PointDerivatives, PositionsAreTheSameWithAndWithoutNormals) {
  RandomVectors random(kDerivativeSeed);
  CpuArena arena(2);
  const LatticeStructure structure = ObliqueStructure({2, 3, 1}, {2, 1, 3});
  const std::vector<Vec3d> control_points = random.Jittered(structure, kJitter);
  const SortedPoints points(structure, random.Around(structure, 999), random.Units(999), arena);
  std::vector<Vec3d> both(2 * 999), alone(999);

  EXPECT_OK(Deform(points, control_points, PointNormals::kWanted, arena, NeverStop, both));
  EXPECT_OK(Deform(points, control_points, PointNormals::kNone, arena, NeverStop, alone));

  EXPECT_EQ(std::memcmp(both.data(), alone.data(), alone.size() * sizeof(Vec3d)), 0);
}

TEST(PointDerivatives, SumsHaveTheSameBitsOnOneThreadAndOnEight) {
  constexpr size_t kPoints = 100'000;
  RandomVectors random(kDerivativeSeed + 4);
  // Also on a machine with fewer cores.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
  CpuArena one(1), eight(8);
  const LatticeStructure structure = ObliqueStructure({3, 2, 1}, {2, 1, 3});
  const std::vector<Vec3d> control_points = random.Jittered(structure, kJitter);
  const SortedPoints points(structure, random.Around(structure, kPoints), random.Units(kPoints),
                            one);
  const std::vector<Vec3d> cotangents = random.Some(2 * kPoints);
  const auto gradient_on = [&](CpuArena& arena) {
    std::vector<Vec3d> gradient(control_points.size());
    EXPECT_OK(ApplyJacobianTranspose(points, control_points, cotangents, PointNormals::kWanted,
                                     arena, NeverStop, gradient));
    return gradient;
  };
  const std::vector<Vec3d> expected = gradient_on(one);

  for (int run = 0; run < 5; ++run) {
    const std::vector<Vec3d> got = gradient_on(eight);
    ASSERT_EQ(std::memcmp(got.data(), expected.data(), got.size() * sizeof(Vec3d)), 0);
  }
}

}  // namespace
}  // namespace latticed
