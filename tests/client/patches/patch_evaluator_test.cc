// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The client's evaluation against the definition in double: positions, normals, tolerances.
#include "client/cpp/library/patches/patch_evaluator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>
#include <set>

#include "tests/client/patches/evaluated_scene.h"
#include "tests/client/patches/shared_bits.h"
#include "tests/client/patches/surface_error.h"
#include "tests/support/definition.h"
#include "tests/support/real_meshes.h"

namespace latticed::client {
namespace {

using testing::Barycentrics;
using testing::Compare;
using testing::DrawPatchScene;
using testing::EvaluateScene;
using testing::MakePatchScene;
using testing::PatchScene;
using testing::PatternOf;
using testing::Worst;

constexpr RestNormals kEveryKind[] = {RestNormals::kFacet, RestNormals::kSmooth,
                                      RestNormals::kNone};

TEST(PatchEvaluator, MatchesTheDefinitionOnRandomScenes) {
  size_t outside = 0, seams = 0;
  std::set<std::array<int, 3>> degrees;
  for (uint32_t seed = 0; seed < testing::kRandomPatchScenes; ++seed) {
    SCOPED_TRACE(seed);
    const PatchScene scene = DrawPatchScene(seed, 0.4, kEveryKind[seed % 3]);

    const Worst worst =
        Compare(scene, EvaluateScene(scene, testing::kSceneTolerance * scene.size()));

    EXPECT_LE(worst.position, 1);
    EXPECT_LE(worst.normal, testing::kNormalTolerance);
    outside += scene.plan->outside_patches;
    seams += scene.plan->seams.size();
    degrees.insert(scene.plan->structure.degree);
  }
  EXPECT_GT(outside, 1000u);
  EXPECT_GT(seams, 100u);
  EXPECT_GT(degrees.size(), 20u);
}

// Samples every triangle at its middle and at one random point.
double LargestDistance(const PatchScene& scene, const PatchSurface& surface) {
  const DirectFfd direct(*scene.plan, scene.control_points);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  double largest = 0;
  for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
    const AdaptivePattern& pattern = PatternOf(surface, p);
    for (const auto& triangle : pattern.triangles) {
      double x = uniform(random), y = uniform(random);
      if (x + y > 1) x = 1 - x, y = 1 - y;
      for (const std::array<double, 3> weight :
           {std::array{1.0 / 3, 1.0 / 3, 1.0 / 3}, std::array{1 - x - y, x, y}}) {
        Vec3d chord;
        std::array<double, 3> at{};
        for (size_t c = 0; c < 3; ++c) {
          chord += weight[c] * ToDouble(surface.positions[surface.first_points[p] + triangle[c]]);
          const auto corner = Barycentrics(pattern, triangle[c]);
          for (size_t a = 0; a < 3; ++a) at[a] += weight[c] * corner[a];
        }
        const Vec3d exact = direct.EvaluatePosition(p, at).position;
        largest = std::max(largest, Norm(chord + scene.plan->local_origin - exact));
      }
    }
  }
  return largest;
}

TEST(PatchEvaluator, PointsAreWithinThePositionError) {
  size_t near = 0;
  for (uint32_t seed = 0; seed < testing::kRandomPatchScenes; ++seed) {
    SCOPED_TRACE(seed);
    const PatchScene scene = DrawPatchScene(seed, 0.4, RestNormals::kNone);
    auto evaluator = PatchEvaluator::Create(scene.read, scene.plan->structure);
    ASSERT_OK(evaluator);
    const auto error = evaluator->PositionError(scene.control_points);
    ASSERT_OK(error);
    const PatchSurface surface = EvaluateScene(scene, testing::kSceneTolerance * scene.size());
    const DirectFfd direct(*scene.plan, scene.control_points);
    double largest = 0;
    for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
      for (size_t i = 0; i < PatternOf(surface, p).points.size(); ++i) {
        const Vec3d exact =
            direct.EvaluatePosition(p, Barycentrics(PatternOf(surface, p), i)).position;
        const Vec3d got = ToDouble(surface.positions[surface.first_points[p] + i]);
        largest = std::max(largest, Norm(got + scene.plan->local_origin - exact));
      }
    }

    EXPECT_LE(largest, *error);
    EXPECT_LE(*error, 1e-4 * scene.size());
    near += largest > 0.1 * *error;
  }
  EXPECT_GT(near, 60u);  // so that the bound says something
}

TEST(PatchEvaluator, TrianglesAreWithinTheTolerance) {
  size_t held = 0, tight = 0;
  for (uint32_t seed = 0; seed < testing::kRandomPatchScenes; ++seed) {
    SCOPED_TRACE(seed);
    const PatchScene scene = DrawPatchScene(seed, 0.4, RestNormals::kNone);
    for (const double share : {1e-2, 3e-4}) {
      const double tolerance = share * scene.size();
      const PatchSurface surface = EvaluateScene(scene, tolerance);
      const double largest = LargestDistance(scene, surface);
      // The points themselves are up to sqrt(3) times what Compare allows off.
      const double points = 2e-5 * scene.size();
      EXPECT_LE(largest, surface.error + points);
      held += surface.error <= tolerance;
      tight += largest > 0.5 * surface.error;
    }
  }
  EXPECT_GT(held, 120u);
  EXPECT_GT(tight, 50u);  // so that the bound says something
}

TEST(PatchEvaluator, KnowsWhatLevelFiveLeaves) {
  const PatchScene scene = DrawPatchScene(3, 0.4, RestNormals::kNone);

  const PatchSurface surface = EvaluateScene(scene, 1e-9 * scene.size());

  EXPECT_GT(surface.error, 1e-9 * scene.size());
  EXPECT_LE(LargestDistance(scene, surface), surface.error + 2e-5 * scene.size());
}

TEST(PatchEvaluator, TakesUnknownBoundsForTheLargest) {
  PatchScene scene = DrawPatchScene(3, 0.4, RestNormals::kNone);
  scene.edge_bounds[scene.plan->patches[0].edge[0]] = 255;

  const PatchSurface surface = EvaluateScene(scene, scene.size());

  EXPECT_TRUE(std::isinf(surface.error));
  EXPECT_EQ(PatternKey::FromCode(surface.patterns[0])->levels[0], 5);
}

TEST(PatchEvaluator, WorksOnRealMeshes) {
  const std::vector<testing::RealMesh> meshes = testing::RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const testing::RealMesh& real : meshes) {
    SCOPED_TRACE(real.name);
    const auto lattice = FitLattice(real.mesh.ComputeBounds(), {6, 6, 6}, {2, 2, 2}, 0.05);
    for (const RestNormals normals : {RestNormals::kFacet, RestNormals::kSmooth}) {
      const PatchScene scene = MakePatchScene(real.mesh, lattice->structure,
                                              testing::Jitter(lattice->structure, 0.1, 1), normals);
      const double tolerance = 1e-4 * scene.size();

      const PatchSurface surface = EvaluateScene(scene, tolerance);

      const Worst worst = Compare(scene, surface);
      EXPECT_LE(worst.position, 1);
      EXPECT_LE(worst.normal, testing::kNormalTolerance);
      EXPECT_EQ(testing::SharedPointsCheck(scene, surface).Count().different, 0u);
      EXPECT_LE(LargestDistance(scene, surface), tolerance + 2e-5 * scene.size());
      std::cout << real.name << ": " << worst.points << " points, " << worst.position
                << " of what is allowed, normals " << worst.normal << " kappa rad\n";
    }
  }
}

// Where all control points of a box coincide, normals are those at rest.
TEST(PatchEvaluator, KeepsRestNormalsWhereTheDeformationHasNoVolume) {
  const PolygonMesh mesh = testing::TorusMesh(8, 6);
  const LatticeStructure structure = testing::MakeStructure(mesh.ComputeBounds(), {});
  const std::vector<Vec3d> point(static_cast<size_t>(structure.control_point_count()),
                                 Vec3d{0.1, 0.2, 0.3});
  const PatchScene scene = MakePatchScene(mesh, structure, point, RestNormals::kFacet);

  const PatchSurface surface = EvaluateScene(scene, 1);

  const DirectFfd direct(*scene.plan, scene.plan->identity_points);
  for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
    const Vec3d normal = ToDouble(surface.normals[surface.first_points[p]]);
    EXPECT_LE(testing::Angle(normal, direct.RestFacetNormal(p)), 6e-5);
  }
}

}  // namespace
}  // namespace latticed::client
