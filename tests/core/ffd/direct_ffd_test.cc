// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/direct_ffd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

constexpr uint32_t kDirectFfdSeed = 7;

void ExpectNear(Vec3d got, Vec3d expected, double tolerance) {
  EXPECT_NEAR(got.x, expected.x, tolerance);
  EXPECT_NEAR(got.y, expected.y, tolerance);
  EXPECT_NEAR(got.z, expected.z, tolerance);
}

// An oblique, left-handed frame, so that a mix-up of axes is noticed.
LatticeStructure ObliqueStructure(std::array<int, 3> degree) {
  LatticeStructure s;
  s.degree = degree;
  s.size = {degree[0] + 2, degree[1] + 1, degree[2] + 3};
  for (size_t a = 0; a < 3; ++a) s.knots[a] = ClampedUniformKnots(s.degree[a], s.size[a]);
  s.frame = {{1, 2, 3}, {Vec3d{2, 0.2, 0}, Vec3d{0.1, 0.3, 3}, Vec3d{0, 4, 0.5}}};
  return s;
}

std::vector<Vec3d> Jittered(const LatticeStructure& s, double amount) {
  std::mt19937 random(kDirectFfdSeed);
  std::uniform_real_distribution<double> uniform(-amount, amount);
  std::vector<Vec3d> points = IdentityControlPoints(s);
  for (Vec3d& p : points) p += Vec3d{uniform(random), uniform(random), uniform(random)};
  return points;
}

TEST(EvaluateWorld, IdentityAtRestAtEveryDegree) {
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        const LatticeStructure s = ObliqueStructure({u, v, w});
        ASSERT_OK(Validate(s));
        const Vec3d world = s.frame.origin + 0.3 * s.frame.edges[0] + 0.9 * s.frame.edges[1] +
                            0.5 * s.frame.edges[2];

        const DeformedPoint p = EvaluateWorld(s, IdentityControlPoints(s), world);

        EXPECT_TRUE(p.inside);
        ExpectNear(p.position, world, 1e-13);
        ExpectNear(p.jacobian[0], {1, 0, 0}, 1e-12);
        ExpectNear(p.jacobian[1], {0, 1, 0}, 1e-12);
        ExpectNear(p.jacobian[2], {0, 0, 1}, 1e-12);
      }
    }
  }
}

TEST(EvaluateWorld, JacobianMatchesDifferences) {
  constexpr double kStep = 1e-6;
  const LatticeStructure s = ObliqueStructure({3, 2, 1});
  const std::vector<Vec3d> points = Jittered(s, 0.5);
  const Vec3d world =
      s.frame.origin + 0.37 * s.frame.edges[0] + 0.61 * s.frame.edges[1] + 0.43 * s.frame.edges[2];

  const DeformedPoint p = EvaluateWorld(s, points, world);

  for (int axis = 0; axis < 3; ++axis) {
    Vec3d step;
    step[axis] = kStep;
    const Vec3d difference = EvaluateWorld(s, points, world + step).position -
                             EvaluateWorld(s, points, world - step).position;
    ExpectNear(p.jacobian[static_cast<size_t>(axis)], difference / (2 * kStep), 1e-8);
  }
}

TEST(EvaluateWorld, OutsideIsTheIdentity) {
  const LatticeStructure s = ObliqueStructure({2, 2, 2});

  const DeformedPoint p = EvaluateWorld(s, Jittered(s, 0.5), {100, 0, 0});

  EXPECT_FALSE(p.inside);
  EXPECT_EQ(p.position, (Vec3d{100, 0, 0}));
  EXPECT_EQ(p.jacobian[1], (Vec3d{0, 1, 0}));
}

TEST(EvaluateVolume, IsTheBilinearFormulaAtDegreeOne) {
  LatticeStructure s;
  s.degree = {1, 1, 1};
  s.size = {2, 2, 2};
  for (auto& knots : s.knots) knots = {0, 0, 1, 1};
  s.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  std::vector<Vec3d> points = IdentityControlPoints(s);
  points[7] = {3, 1, 1};  // the corner u = v = w = 1 moved by 2 along x

  const VolumePoint p = EvaluateVolume(s, points, {1, 1, 1}, {0.5, 0.5, 0.25});

  ExpectNear(p.position, {0.5 + 2 * 0.0625, 0.5, 0.25}, 1e-15);
  ExpectNear(p.derivatives[0], {1 + 2 * 0.125, 0, 0}, 1e-15);
  ExpectNear(p.derivatives[2], {2 * 0.25, 0, 1}, 1e-15);
}

// One triangle in the plane z = 1/2 of the unit cube, under a lattice of degree 1.
class OnePatch : public ::testing::Test {
 protected:
  OnePatch() {
    auto mesh = std::make_shared<PolygonMesh>();
    mesh->positions = {{0.1, 0.1, 0.5}, {0.9, 0.1, 0.5}, {0.1, 0.7, 0.5}};
    mesh->face_offsets = {0, 3};
    mesh->corner_vertices = {0, 1, 2};
    LatticeStructure& s = plan_.structure;
    s.degree = {1, 1, 1};
    s.size = {2, 2, 2};
    for (auto& knots : s.knots) knots = {0, 0, 1, 1};
    s.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
    plan_.boxes = {{.span = {1, 1, 1}}, {}};
    for (const Vec3d& p : mesh->positions) plan_.vertices.push_back({.world = p, .parameter = p});
    plan_.patches = {{.vertex = {0, 1, 2}}};
    plan_.sources = {{.corners = {0, 1, 2}, .barycentrics = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}};
    plan_.vertex_normals = {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}};
    plan_.mesh = mesh;
    points_ = IdentityControlPoints(s);
  }

  DeformPlan plan_;
  std::vector<Vec3d> points_;
};

TEST_F(OnePatch, RestNormalsAreTheMeshs) {
  const DirectFfd ffd(plan_, points_);

  const auto facet = ffd.Evaluate(0, {0.2, 0.3, 0.5}, DirectFfd::Normal::kFacet);
  const auto smooth = ffd.Evaluate(0, {0.5, 0.5, 0}, DirectFfd::Normal::kSmooth);

  ExpectNear(facet.position, {0.34, 0.4, 0.5}, 1e-15);
  ExpectNear(facet.normal, {0, 0, 1}, 1e-15);
  EXPECT_NEAR(facet.kappa, std::sqrt(3), 1e-14);
  ExpectNear(smooth.normal, {std::sqrt(0.5), 0, std::sqrt(0.5)}, 1e-15);
}

TEST_F(OnePatch, FacetNormalIsThatOfTheDeformedSurface) {
  points_[7] += Vec3d{0.3, -0.2, 0.9};
  points_[1] += Vec3d{0.1, 0.4, -0.3};
  const DirectFfd ffd(plan_, points_);
  constexpr double kStep = 1e-6;

  const auto p = ffd.Evaluate(0, {0.2, 0.3, 0.5}, DirectFfd::Normal::kFacet);
  const auto u = ffd.Evaluate(0, {0.2 - kStep, 0.3 + kStep, 0.5}, DirectFfd::Normal::kFacet);
  const auto v = ffd.Evaluate(0, {0.2 - kStep, 0.3, 0.5 + kStep}, DirectFfd::Normal::kFacet);

  const Vec3d cross = Cross(u.position - p.position, v.position - p.position);
  ExpectNear(p.normal, cross / Norm(cross), 1e-5);
  EXPECT_FALSE(p.substituted);
}

TEST_F(OnePatch, CollapsedLatticeFallsBackToTheRestNormal) {
  points_.assign(points_.size(), Vec3d{1, 2, 3});
  const DirectFfd ffd(plan_, points_);

  const auto facet = ffd.Evaluate(0, {1, 0, 0}, DirectFfd::Normal::kFacet);
  const auto smooth = ffd.Evaluate(0, {0, 1, 0}, DirectFfd::Normal::kSmooth);

  EXPECT_TRUE(facet.substituted);
  ExpectNear(facet.normal, {0, 0, 1}, 1e-15);
  EXPECT_NEAR(Norm(smooth.normal), 1, 1e-15);
}

TEST_F(OnePatch, AFoldTakesTheNormalOfTheCentroid) {
  // The edge v = 0 of the cube collapses to a point, so J is singular only there.
  for (size_t i : {0u, 1u, 4u, 5u}) points_[i] = {0.5, 0, 0.5};
  for (uint32_t v : {0u, 1u}) plan_.vertices[v].parameter.y = 0;
  const DirectFfd ffd(plan_, points_);

  const auto corner = ffd.Evaluate(0, {1, 0, 0}, DirectFfd::Normal::kFacet);

  EXPECT_TRUE(corner.substituted);
  ExpectNear(corner.normal, ffd.SubstituteNormal(0, DirectFfd::Normal::kFacet), 0);
  ExpectNear(corner.normal, {0, 0, 1}, 1e-12);
}

TEST_F(OnePatch, DegenerateFacesStillHaveAUnitNormal) {
  auto mesh = std::make_shared<PolygonMesh>(*plan_.mesh);
  mesh->positions[2] = mesh->positions[1];
  plan_.mesh = mesh;
  plan_.vertices[2] = plan_.vertices[1];
  plan_.vertex_normals.assign(3, Vec3f{});
  const DirectFfd ffd(plan_, points_);

  for (auto normal : {DirectFfd::Normal::kFacet, DirectFfd::Normal::kSmooth}) {
    EXPECT_EQ(ffd.Evaluate(0, {0.5, 0.25, 0.25}, normal).normal, (Vec3d{0, 0, 1}));
  }
}

}  // namespace
}  // namespace latticed
