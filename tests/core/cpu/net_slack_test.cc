// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The slack of bounds by control nets: at rest a surface does not bend, so what is computed is rounding alone.
#include "core/adaptive/net_slack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "core/adaptive/net_curvature.h"
#include "core/cpu/gemm/patch_sampler.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

// The largest bound of a patch, by the net of samples that are taken as the pipelines take them.
double LargestNetBound(const StageMatrices& stage, const PatchSampler& sampler, size_t patch) {
  std::vector<double> samples(3 * stage.m);
  sampler.Sample(patch, samples.data(), nullptr, {}, stage.m);
  std::vector<Vec3d> net(stage.m);
  for (size_t i = 0; i < stage.m; ++i) {
    for (size_t j = 0; j < stage.m; ++j) {
      for (size_t axis = 0; axis < 3; ++axis) {
        net[i][static_cast<int>(axis)] +=
            stage.inverse[j * stage.m + i] * samples[axis * stage.m + j];
      }
    }
  }
  const auto bounds = BoundNet(stage.degree, [&](int i) { return net[static_cast<size_t>(i)]; });
  return std::max(std::ranges::max(bounds.edge), std::ranges::max(bounds.mixed));
}

struct SlackCase {
  const char* name;
  LatticeOptions own, turned;
  Vec3d far;  // by which all control points are moved, and the surface with them
  double first_knot = 0;
  bool weighted = false;
};

void ExpectSlackCovers(const SlackCase& one, std::array<int, 3> degree) {
  SCOPED_TRACE(fmt::format("{}, degree {} {} {}", one.name, degree[0], degree[1], degree[2]));
  PolygonMesh mesh = TorusMesh(7, 5);
  LatticeOptions own = one.own, turned = one.turned;
  own.degree = turned.degree = degree;
  std::array structures{MakeStructure(mesh.ComputeBounds(), own),
                        MakeStructure(mesh.ComputeBounds(), turned)};
  for (LatticeStructure& s : structures) {
    for (auto& knots : s.knots) {
      for (double& knot : knots) knot += one.first_knot;
    }
  }
  VertexWeights weights;
  if (one.weighted) weights = RandomWeights(mesh, 7);
  ASSERT_OK_AND_ASSIGN(const auto plan,
                       MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structures[0],
                                {}, NeverStop, weights, std::span(structures).subspan(1)));
  std::vector<Vec3d> points = plan->identity_points;
  if (!one.weighted) {
    for (Vec3d& p : points) p += one.far;
  }
  ASSERT_OK_AND_ASSIGN(const auto stage, StageMatrices::Get(plan->surface_degree(), 1));
  const PatchSampler sampler(*plan, *stage, points);
  const NetSlack slack(*plan);
  const std::vector<double> norms = slack.Norms(points);
  double largest = 0;
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    const double bound = LargestNetBound(*stage, sampler, p);
    ASSERT_LE(bound, slack.Of(p, norms)) << "patch " << p;
    largest = std::max(largest, bound);
  }
  EXPECT_GT(largest, 0);
}

TEST(NetSlack, CoversWhatRoundingMakesOfSurfacesThatDoNotBend) {
  const std::vector<SlackCase> cases{
      {"around the mesh", {.scale = 2}, {.scale = 2, .turn = 0.5}, {}},
      {"weights", {.scale = 2}, {.scale = 2, .turn = 0.5}, {}, 0, true},
      {"moved far", {.scale = 2}, {.scale = 2, .turn = 0.5}, {1e5, 2e5, -3e5}},
      {"knots far from 0", {.scale = 2}, {.scale = 2, .turn = 0.5}, {}, 1e6}};
  for (const SlackCase& one : cases) {
    for (const std::array<int, 3> degree :
         {std::array{1, 1, 1}, std::array{1, 2, 1}, std::array{2, 2, 1}, std::array{2, 2, 2},
          std::array{3, 2, 2}, std::array{3, 3, 2}, std::array{3, 3, 3}}) {
      ExpectSlackCovers(one, degree);
    }
  }
}

// A short knot span matters to the patches in it alone.
TEST(NetSlack, OfAShortSpanIsThatOfItsPatches) {
  PolygonMesh mesh = TorusMesh(14, 10);
  LatticeStructure s = MakeStructure(mesh.ComputeBounds(), {.extra = {3, 3, 3}, .scale = 2});
  s.knots[0][4] = s.knots[0][3] + 1e-9;
  ASSERT_OK_AND_ASSIGN(const auto plan,
                       MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), s));
  const NetSlack slack(*plan);
  const std::vector<double> norms = slack.Norms(plan->identity_points);
  size_t others = 0;
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    if (plan->boxes[plan->patches[p].box].span[0] == 3) continue;
    ++others;
    EXPECT_LT(slack.Of(p, norms), 1e-8) << "patch " << p;
  }
  EXPECT_GT(others, 0u);
}

}  // namespace
}  // namespace latticed::testing
