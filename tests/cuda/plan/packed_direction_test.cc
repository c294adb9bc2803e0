// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Packing a direction keeps it to 2^-29 rad. Needs no device.
#include "cuda/plan/packed_direction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/ffd/carried_normal.h"

namespace latticed::testing {
namespace {

using kernels::PackDirection;
using kernels::UnpackDirection;

constexpr uint32_t kSeed = 20261121;

double Angle(Vec3d a, Vec3d b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

TEST(PackedDirection, KeepsDirections) {
  std::vector<Vec3d> directions;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, -1e-12, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1e-12, 1.0}) {
        if (Norm(Vec3d{x, y, z}) > 0.5) directions.push_back(Unit({x, y, z}));
      }
    }
  }
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100'000; ++i) {
    directions.push_back(Unit({normal(random), normal(random), normal(random)}));
  }
  for (const Vec3d& d : directions) {
    const Vec3d got = UnpackDirection(PackDirection(d));
    ASSERT_LE(Angle(got, d), 0x1p-29)
        << "seed " << kSeed << ": " << d.x << ' ' << d.y << ' ' << d.z;
    ASSERT_NEAR(Norm(got), 1, 1e-15);
  }
}

}  // namespace
}  // namespace latticed::testing
