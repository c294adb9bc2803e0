// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/weights/vertex_weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/deform_plan.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kVertexWeightsSeed = 11;

VertexWeights Shared(std::vector<float> weights) {
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

VertexWeights AnyWeights(const PolygonMesh& mesh) {
  std::mt19937 random(kVertexWeightsSeed);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = uniform(random);
  return Shared(std::move(weights));
}

// The weight that a patch's source triangle has at a point of the patch.
double SourceWeight(const DeformPlan& plan, size_t patch, const std::array<double, 3>& b) {
  const PatchSource& source = plan.sources[patch];
  double weight = 0;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t k = 0; k < 3; ++k) {
      weight += b[c] * source.barycentrics[c][k] *
                double{(*plan.mesh_weights)[plan.mesh->corner_vertices[source.corners[k]]]};
    }
  }
  return weight;
}

TEST(CheckVertexWeights, RefusesOtherCountsAndValues) {
  const PolygonMesh mesh = OneTriangle();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_OK(CheckVertexWeights(mesh, std::vector<float>{0, 0.5f, 1}));
  for (const std::vector<float>& bad :
       {std::vector<float>{}, {0, 1}, {0, 1, 1, 0}, {0, nan, 1}, {0, 1, -1e-6f}, {1.0001f, 1, 1}}) {
    const absl::Status status = CheckVertexWeights(mesh, bad);
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
    EXPECT_TRUE(std::string(status.message()).starts_with("weights")) << status;
  }
}

TEST(WeightGradient, IsThatOfTheLinearFunction) {
  const Vec3d slope{0.3, -0.2, 0.7};
  const std::array<Vec3d, 3> corners{Vec3d{1, 2, 3}, Vec3d{2, 2.5, 3}, Vec3d{1, 3, 4.5}};
  std::array<double, 3> weights;
  for (size_t c = 0; c < 3; ++c) weights[c] = Dot(slope, corners[c]);

  const Vec3d gradient = WeightGradient(corners, weights);

  for (size_t c = 1; c < 3; ++c) {
    EXPECT_NEAR(Dot(gradient, corners[c] - corners[0]), weights[c] - weights[0], 1e-14);
  }
  EXPECT_NEAR(Dot(gradient, Cross(corners[1] - corners[0], corners[2] - corners[0])), 0, 1e-14);
}

TEST(WeightGradient, IsZeroWithoutArea) {
  EXPECT_EQ(WeightGradient({Vec3d{0, 0, 0}, Vec3d{1, 1, 1}, Vec3d{2, 2, 2}}, {0, 1, 0}), Vec3d{});
  EXPECT_EQ(WeightGradient({Vec3d{}, Vec3d{}, Vec3d{}}, {0, 1, 0}), Vec3d{});
}

// Deformed = x + w (F(x) - x), with F from a plan without weights and w from the source triangle.
TEST(DirectFfd, WeightsBlendRestAndDeformed) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 3, 1}, .scale = 0.8});
  const auto shared = std::make_shared<const PolygonMesh>(mesh);
  ASSERT_OK_AND_ASSIGN(const auto plain, MakePlan(shared, structure));
  ASSERT_OK_AND_ASSIGN(const auto plan,
                       MakePlan(shared, structure, {}, NeverStop, AnyWeights(mesh)));
  ASSERT_EQ(plan->patches.size(), plain->patches.size());
  ASSERT_FALSE(plain->is_weighted());
  const std::vector<Vec3d> points = Jitter(structure, 0.2, kVertexWeightsSeed);
  const DirectFfd ffd(*plan, points), full(*plain, points), rest(*plain, plain->identity_points);
  const std::array<double, 3> b{0.2, 0.3, 0.5};
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    const Vec3d x = rest.EvaluatePosition(p, b).position;
    const Vec3d wanted = x + SourceWeight(*plan, p, b) * (full.EvaluatePosition(p, b).position - x);
    ASSERT_LE(Norm(ffd.EvaluatePosition(p, b).position - wanted), 1e-14) << "patch " << p;
  }
}

TEST(DirectFfd, WeightedNormalsAreThoseOfTheSurface) {
  constexpr double kStep = 1e-6;
  const PolygonMesh mesh = TorusMesh(9, 6);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.degree = {2, 3, 1}});
  ASSERT_OK_AND_ASSIGN(const auto plan, MakePlan(std::make_shared<const PolygonMesh>(mesh),
                                                 structure, {}, NeverStop, AnyWeights(mesh)));
  const std::vector<Vec3d> points = Jitter(structure, 0.1, kVertexWeightsSeed);
  const DirectFfd ffd(*plan, points);
  const auto at = [&](size_t p, double s, double t) {
    return ffd.EvaluatePosition(p, {1 - s - t, s, t}).position;
  };
  size_t compared = 0;
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    const auto point = ffd.Evaluate(p, {0.5, 0.2, 0.3}, DirectFfd::Normal::kFacet);
    const Vec3d by_s = at(p, 0.2 + kStep, 0.3) - at(p, 0.2 - kStep, 0.3);
    const Vec3d by_t = at(p, 0.2, 0.3 + kStep) - at(p, 0.2, 0.3 - kStep);
    const double sine = Norm(Cross(by_s, by_t)) / (Norm(by_s) * Norm(by_t));
    if (!(sine > 0.01) || Norm(by_s) < 1e-8 || Norm(by_t) < 1e-8) continue;
    ++compared;
    ASSERT_LE(Norm(point.normal - Cross(by_s, by_t) / Norm(Cross(by_s, by_t))), 1e-5)
        << "patch " << p;
  }
  EXPECT_GE(compared, plan->patches.size() / 2);
}

TEST(MakePlan, VerticesAtOnePositionAreOneWhereTheirWeightsAre) {
  PolygonMesh mesh;  // two triangles with copies of their common corners
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.face_offsets = {0, 3, 6};
  mesh.corner_vertices = {0, 1, 2, 3, 4, 5};
  const auto shared = std::make_shared<const PolygonMesh>(mesh);
  LatticeStructure structure = MakeStructure({{-1, -1, -1}, {2, 2, 2}}, {.extra = {0, 0, 0}});
  ASSERT_OK_AND_ASSIGN(const auto same, MakePlan(shared, structure, {}, NeverStop,
                                                 Shared({0, 0.5f, 1, 0.5f, 0, 1})));
  ASSERT_OK_AND_ASSIGN(const auto other, MakePlan(shared, structure, {}, NeverStop,
                                                  Shared({0, 0.5f, 1, 0.25f, 0, 1})));
  EXPECT_EQ(same->vertices.size(), 4u);
  EXPECT_EQ(other->vertices.size(), 5u);
}

}  // namespace
}  // namespace latticed::testing
