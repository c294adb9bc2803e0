// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The comparator's control points, by its steps on the host, against those of the control-net
// pipeline.
#include "tests/bench/paper/bezier_net/bezier_net.h"

#include <gtest/gtest.h>

#include <random>

#include "core/cpu/cpu_backend.h"
#include "tests/bench/exact_mesh.h"
#include "tests/bench/paper/bezier_net/bezier_nets_on_host.h"

namespace latticed::bench {
namespace {

constexpr size_t kPatches = 301;  // no multiple of a group

class BezierNetTest : public ::testing::TestWithParam<std::array<int, 3>> {};

TEST_P(BezierNetTest, NetsAreThoseOfTheControlNetPipeline) {
  const auto plan = MakeExactPlan(kPatches, GetParam());
  ASSERT_TRUE(plan.ok()) << plan.status();
  std::vector<Vec3d> points = IdentityControlPoints((*plan)->structure);
  std::mt19937 random(20140603);
  std::uniform_real_distribution<double> jitter(-0.05, 0.05);
  for (Vec3d& p : points) p += Vec3d{jitter(random), jitter(random), jitter(random)};

  const std::vector<NetPoint> nets = BezierNetsOnHost(**plan, points);

  const auto backend = MakeCpuBackend({.threads = 1});
  const auto target = backend->Prepare(*plan, Pipeline::kControlNet);
  ASSERT_TRUE(target.ok()) << target.status();
  const auto expected = (*target)->ControlNets(points, 0, kPatches);
  ASSERT_TRUE(expected.ok()) << expected.status();
  const auto m = static_cast<size_t>(BernsteinCount((*plan)->structure.patch_degree()));
  ASSERT_EQ(nets.size(), kPatches * (m + 1));
  ASSERT_EQ(expected->size(), 3 * kPatches * m);
  const auto at = [](const NetPoint& p) { return ToDouble(Vec3f{p.x, p.y, p.z}); };
  double worst = 0;
  for (size_t patch = 0; patch < kPatches; ++patch) {
    const NetPoint* net = nets.data() + patch * (m + 1);
    const Vec3d centre = (*plan)->local_origin + at(net[m]);
    for (size_t i = 0; i < m; ++i) {
      const double* e = expected->data() + 3 * (patch * m + i);
      worst = std::max(worst, Norm(centre + at(net[i]) - Vec3d{e[0], e[1], e[2]}));
    }
  }
  EXPECT_LE(worst, 1e-7 * (*plan)->mesh_bounds.diagonal());  // two roundings to float32
}

INSTANTIATE_TEST_SUITE_P(Degrees, BezierNetTest,
                         ::testing::Values(std::array{1, 1, 1}, std::array{2, 2, 2},
                                           std::array{1, 2, 3}, std::array{3, 3, 3}));

}  // namespace
}  // namespace latticed::bench
