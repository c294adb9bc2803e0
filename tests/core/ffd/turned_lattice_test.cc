// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of lattices that are turned against each other, compared with the sum of the displacements of each lattice by
// formula (1): DirectFfd evaluates one polynomial per lattice and patch, EvaluateWorld finds the knot box of each point.
#include "core/ffd/turned/turned_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kTurnedSeed = 20261201;
constexpr double kTurnedNoise = 0.1;

struct TurnedScene {
  std::shared_ptr<const DeformPlan> plan;
  std::vector<LatticeStructure> structures;
  std::vector<std::vector<Vec3d>> points;  // by lattice
  std::vector<Vec3d> all;
};

TurnedScene MakeTurnedScene(PolygonMesh mesh, std::span<const LatticeOptions> lattices,
                            VertexWeights weights = nullptr) {
  TurnedScene scene;
  for (const LatticeOptions& options : lattices) {
    scene.structures.push_back(MakeStructure(mesh.ComputeBounds(), options));
    const auto seed = kTurnedSeed + static_cast<uint32_t>(scene.structures.size());
    scene.points.push_back(Jitter(scene.structures.back(), kTurnedNoise, seed));
    scene.all.insert(scene.all.end(), scene.points.back().begin(), scene.points.back().end());
  }
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), scene.structures[0],
                       {}, NeverStop, std::move(weights), std::span(scene.structures).subspan(1));
  EXPECT_OK(plan);
  if (plan.ok()) scene.plan = *plan;
  return scene;
}

// Within 1e-13 of the sum of all displacements at random points of each patch.
void ExpectSum(const TurnedScene& scene) {
  ASSERT_NE(scene.plan, nullptr);
  const DeformPlan& plan = *scene.plan;
  ASSERT_EQ(plan.control_point_count(), scene.all.size());
  const DirectFfd direct(plan, scene.all);
  std::mt19937 random(kTurnedSeed);
  std::uniform_real_distribution<double> uniform(0.01, 1);
  const double most = 1e-13 * plan.mesh_bounds.diagonal();
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    std::array<double, 3> b{uniform(random), uniform(random), uniform(random)};
    const double sum = b[0] + b[1] + b[2];
    Vec3d world;
    for (size_t c = 0; c < 3; ++c) {
      b[c] /= sum;
      world += b[c] * plan.vertices[plan.patches[p].vertex[c]].world;
    }
    Vec3d expected = world;
    std::array<Vec3d, 3> jacobian{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    for (size_t k = 0; k < scene.structures.size(); ++k) {
      const DeformedPoint one = EvaluateWorld(scene.structures[k], scene.points[k], world);
      expected += one.position - world;
      for (size_t a = 0; a < 3; ++a) {
        Vec3d unit;
        unit[static_cast<int>(a)] = 1;
        jacobian[a] += one.jacobian[a] - unit;
      }
    }
    const DeformedPoint found = direct.EvaluatePosition(p, b);
    ASSERT_LE(Norm(found.position - expected), most) << "patch " << p << ", seed " << kTurnedSeed;
    for (size_t a = 0; a < 3; ++a) {
      ASSERT_LE(Norm(found.jacobian[a] - jacobian[a]), 1e-11) << "patch " << p;
    }
    const TurnedMove move = TurnedMoveAt(plan.turned, scene.all, world);
    const Vec3d own = EvaluateWorld(plan.structure, scene.points[0], world).position;
    ASSERT_LE(Norm(own + move.move - expected), most) << "patch " << p;
  }
}

TEST(TurnedLattice, AllMixesOfDegreesAddUp) {
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    SCOPED_TRACE(fmt::format("degree {} {} {}", degree[0], degree[1], degree[2]));
    const std::array<LatticeOptions, 2> lattices{
        LatticeOptions{.degree = degree, .scale = 2},
        LatticeOptions{.degree = {degree[2], degree[0], degree[1]}, .scale = 2, .turn = 0.5}};
    ExpectSum(MakeTurnedScene(TorusMesh(9, 6), lattices));
  }
}

TEST(TurnedLattice, ThreeLatticesAddUpWhereverTheyEnd) {
  const std::array<LatticeOptions, 3> lattices{
      LatticeOptions{.extra = {3, 3, 3}, .scale = 0.7},
      LatticeOptions{.degree = {3, 1, 2}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}},
      LatticeOptions{.knots = KnotKind::kNonUniform, .shear = 0.2, .scale = 0.6, .turn = -2}};
  const TurnedScene scene = MakeTurnedScene(TorusMesh(20, 12), lattices);
  ExpectSum(scene);
  const auto is_outside = [](const KnotSpans& spans) { return spans == kNoSpans; };
  for (const TurnedLattice& lattice : scene.plan->turned) {
    const auto outside = std::ranges::count_if(lattice.spans, is_outside);
    EXPECT_GT(outside, 0);
    EXPECT_LT(outside, static_cast<ptrdiff_t>(scene.plan->patches.size()));
  }
}

// Of a point of a patch, from the source triangle.
double SourceWeightAt(const DeformPlan& plan, size_t patch, const std::array<double, 3>& b) {
  const PatchSource& source = plan.sources[patch];
  double weight = 0;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t vertex = plan.mesh->corner_vertices[source.corners[k]];
      weight += b[c] * source.barycentrics[c][k] * double{(*plan.mesh_weights)[vertex]};
    }
  }
  return weight;
}

// Deformed = x + w (F(x) - x), with F the sum of all lattices at any point of the world. The Jacobian by differences: along
// the sides of the patch, and along the facet normal, where w stays the same.
void ExpectWeighted(const TurnedScene& scene) {
  constexpr double kTurnedStep = 1e-5;
  const DeformPlan& plan = *scene.plan;
  const DirectFfd direct(plan, scene.all);
  const double most = 1e-13 * plan.mesh_bounds.diagonal();
  const std::array<double, 3> b{0.21, 0.32, 0.47};
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    std::array<Vec3d, 3> corners;
    for (size_t c = 0; c < 3; ++c) corners[c] = plan.vertices[plan.patches[p].vertex[c]].world;
    const Vec3d world = b[0] * corners[0] + b[1] * corners[1] + b[2] * corners[2];
    const double weight = SourceWeightAt(plan, p, b);
    const auto weighted = [&](Vec3d x) {
      return x + weight * (EvaluateWorld(plan, scene.all, x).position - x);
    };
    const DeformedPoint found = direct.EvaluatePosition(p, b);
    ASSERT_LE(Norm(found.position - weighted(world)), most) << "patch " << p;
    const auto carry = [&](Vec3d d) {
      return d.x * found.jacobian[0] + d.y * found.jacobian[1] + d.z * found.jacobian[2];
    };
    for (size_t c = 1; c < 3; ++c) {
      std::array<double, 3> ahead = b, behind = b;
      ahead[0] -= kTurnedStep;
      ahead[c] += kTurnedStep;
      behind[0] += kTurnedStep;
      behind[c] -= kTurnedStep;
      const Vec3d slope =
          direct.EvaluatePosition(p, ahead).position - direct.EvaluatePosition(p, behind).position;
      ASSERT_LE(Norm(slope / (2 * kTurnedStep) - carry(corners[c] - corners[0])), 1e-8)
          << "patch " << p;
    }
    const Vec3d normal = direct.RestFacetNormal(p), step = kTurnedStep * normal;
    const Vec3d slope = (weighted(world + step) - weighted(world - step)) / (2 * kTurnedStep);
    ASSERT_LE(Norm(slope - carry(normal)), 1e-7) << "patch " << p;
  }
}

TEST(TurnedLattice, WeightsBlendRestAndTheSum) {
  const PolygonMesh mesh = TorusMesh(20, 12);
  std::mt19937 random(kTurnedSeed);
  std::uniform_real_distribution<float> uniform(-0.5f, 1.5f);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  const std::array<LatticeOptions, 3> lattices{
      LatticeOptions{.extra = {3, 3, 3}, .scale = 0.7},
      LatticeOptions{.degree = {3, 2, 2}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}},
      LatticeOptions{.knots = KnotKind::kNonUniform, .shear = 0.2, .scale = 0.6, .turn = -2}};
  SCOPED_TRACE(fmt::format("seed {}", kTurnedSeed));
  const TurnedScene scene = MakeTurnedScene(
      mesh, lattices, std::make_shared<const std::vector<float>>(std::move(weights)));
  ASSERT_NE(scene.plan, nullptr);
  ASSERT_GT(scene.plan->outside_patches, 0u);
  ASSERT_EQ(scene.plan->surface_degree(), scene.plan->patch_degree() + 1);
  ExpectWeighted(scene);
}

TEST(TurnedLattice, VerticesThatPatchesShareAreCutOnce) {
  const std::array<LatticeOptions, 2> lattices{LatticeOptions{.scale = 2},
                                               LatticeOptions{.scale = 2, .turn = 0.7}};
  const TurnedScene scene = MakeTurnedScene(TorusMesh(9, 6), lattices);
  // A closed surface of one piece and genus 1: V - E + F = 0.
  EXPECT_EQ(scene.plan->vertices.size() + scene.plan->patches.size(), scene.plan->edges.size());
  EXPECT_EQ(scene.plan->turned[0].parameters.size(), scene.plan->vertices.size());
}

// Of each control point of the turned lattice, the patches that it moves are dirty, with all beside them, and few others.
class TurnedKnots : public ::testing::TestWithParam<KnotKind> {};

TEST_P(TurnedKnots, AnEditMakesThePatchesDirtyThatItReaches) {
  const std::array<LatticeOptions, 2> lattices{
      LatticeOptions{.extra = {3, 3, 3}, .scale = 1.2},
      LatticeOptions{.extra = {3, 3, 3}, .knots = GetParam(), .turn = 0.7}};
  const TurnedScene scene = MakeTurnedScene(TorusMesh(16, 10), lattices);
  const DeformPlan& plan = *scene.plan;
  std::vector<Vec3d> points = plan.identity_points;
  const DirectFfd at_rest(plan, plan.identity_points), moved(plan, points);
  size_t dirty_patches = 0, moved_patches = 0;
  for (auto i = static_cast<uint32_t>(plan.turned[0].first_point); i < points.size(); ++i) {
    points[i] += Vec3d{1, 2, 3};
    std::vector<bool> moves(plan.vertices.size());
    for (size_t p = 0; p < plan.patches.size(); ++p) {
      for (const std::array<double, 3> b : {std::array{1 / 3.0, 1 / 3.0, 1 / 3.0},
                                            std::array{1.0, 0.0, 0.0}, std::array{0.0, 0.5, 0.5}}) {
        const Vec3d before = at_rest.EvaluatePosition(p, b).position;
        if (Norm(moved.EvaluatePosition(p, b).position - before) < 1e-9) continue;
        for (const uint32_t v : plan.patches[p].vertex) moves[v] = true;
      }
    }
    size_t beside = 0;
    const DirtySet dirty = DirtyByControlPoints(plan, {{i}});
    for (size_t p = 0; p < plan.patches.size(); ++p) {
      if (std::ranges::none_of(plan.patches[p].vertex, [&](uint32_t v) { return moves[v]; }))
        continue;
      ++beside;
      const auto chunk = static_cast<uint32_t>(p / limits::kPatchesPerChunk);
      ASSERT_TRUE(std::ranges::binary_search(dirty.chunks, chunk)) << "point " << i;
    }
    ASSERT_GE(dirty.patches, beside) << "point " << i;
    moved_patches += beside;
    dirty_patches += dirty.patches;
    points[i] -= Vec3d{1, 2, 3};
  }
  EXPECT_LE(dirty_patches, moved_patches + moved_patches / 2);
}

INSTANTIATE_TEST_SUITE_P(Kinds, TurnedKnots,
                         ::testing::Values(KnotKind::kUniform, KnotKind::kNonUniform,
                                           KnotKind::kUnclamped, KnotKind::kRepeated));

TEST(TurnedLattice, IllegalStructuresAreRefused) {
  auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(9, 6));
  const LatticeStructure own = MakeStructure(mesh->ComputeBounds(), {});
  std::vector<LatticeStructure> turned{own};
  turned[0].degree[1] = 9;
  EXPECT_THAT(MakePlan(mesh, own, {}, NeverStop, nullptr, turned),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace latticed::testing
