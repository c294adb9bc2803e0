// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Certificates against samples of the definition, on lattices and meshes that try to break them.
#include "core/adaptive/adaptive_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/adaptive/adaptive_pattern.h"
#include "core/ffd/direct_ffd.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

constexpr uint32_t kSampleSeed = 23;

struct Scene {
  std::shared_ptr<const DeformPlan> plan;
  std::vector<Vec3d> control_points;
};

Scene MakeScene(PolygonMesh mesh, const testing::LatticeOptions& options, double jitter) {
  Bounds bounds;
  for (const Vec3d& p : mesh.positions) bounds.Extend(p);
  const LatticeStructure structure = testing::MakeStructure(bounds, options);
  auto plan = MakePlan(std::make_shared<PolygonMesh>(std::move(mesh)), structure);
  EXPECT_OK(plan.status());
  return {*plan, testing::Jitter(structure, jitter, kSampleSeed)};
}

Vec3d PointOf(const AdaptivePattern& pattern, size_t point, std::array<double, 3>* barycentrics,
              const DirectFfd& ffd, size_t patch) {
  for (size_t a = 0; a < 3; ++a) {
    (*barycentrics)[a] = double(pattern.points[point][a]) / pattern.denominator;
  }
  return ffd.EvaluatePosition(patch, *barycentrics).position;
}

// The distance from a point of a triangle, at `weight` of its corners, to the surface at equal barycentrics.
double ErrorAt(const AdaptivePattern& pattern, size_t triangle, const std::array<double, 3>& weight,
               const DirectFfd& ffd, size_t patch) {
  std::array<double, 3> at{}, corner;
  Vec3d chord;
  for (size_t c = 0; c < 3; ++c) {
    chord += weight[c] * PointOf(pattern, pattern.triangles[triangle][c], &corner, ffd, patch);
    for (size_t a = 0; a < 3; ++a) at[a] += weight[c] * corner[a];
  }
  return Norm(ffd.EvaluatePosition(patch, at).position - chord);
}

// ErrorAt a point of a random triangle. Every second point is in the middle of the triangle or of a side.
double SampleError(const AdaptivePattern& pattern, const DirectFfd& ffd, size_t patch,
                   std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const size_t triangle = random() % pattern.triangles.size();
  double x = uniform(random), y = uniform(random);
  if (x + y > 1) x = 1 - x, y = 1 - y;
  std::array<double, 3> weight{1 - x - y, x, y};
  if (random() % 4 == 0) weight = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  if (random() % 4 == 0) weight = {0.5, 0.5, 0};
  return ErrorAt(pattern, triangle, weight, ffd, patch);
}

double DeformedSize(const Scene& scene) {
  Bounds bounds;
  for (const Vec3d& p : scene.control_points) bounds.Extend(p);
  return bounds.diagonal();
}

// Checks `samples` points at each of several tolerances, and returns the largest share of a certificate.
double ExpectCertified(const Scene& scene, int samples) {
  const DeformPlan& plan = *scene.plan;
  const DirectFfd ffd(plan, scene.control_points);
  const AdaptiveReference reference(scene.plan);
  const double size = DeformedSize(scene);
  const auto bounds = reference.Bounds(scene.control_points);
  std::mt19937 random(kSampleSeed);
  double largest_share = 0;
  for (const double tolerance : {1e-2 * size, 1e-3 * size, 1e-4 * size}) {
    const AdaptiveTessellation t = reference.Tessellate(bounds, tolerance);
    for (int k = 0; k < samples; ++k) {
      const size_t patch = random() % plan.patches.size();
      const double error = SampleError(AdaptivePattern::Get(t.patterns[patch]), ffd, patch, random);
      // The definition itself is rounded.
      EXPECT_LE(error, t.errors[patch] * (1 + 1e-9) + 1e-12 * size)
          << "patch " << patch << " tolerance " << tolerance << " seed " << kSampleSeed;
      if (t.errors[patch] > 1e-6 * size)
        largest_share = std::max(largest_share, error / t.errors[patch]);
    }
    for (size_t p = 0; p < plan.patches.size(); ++p) {
      const auto& levels = t.patterns[p].levels;
      for (size_t e = 0; e < 3; ++e) {
        EXPECT_EQ(levels[e], t.edge_levels[plan.patches[p].edge[e]]) << "patch " << p;
      }
      if (*std::max_element(levels.begin(), levels.end()) < limits::kMaxEdgeLevel) {
        EXPECT_LE(t.errors[p], tolerance * (1 + 1e-12)) << "patch " << p;
      }
      EXPECT_LE(t.errors[p], t.largest_error);
    }
  }
  return largest_share;
}

TEST(AdaptiveReference, CertifiesRandomLatticesOfEveryDegree) {
  double largest_share = 0;
  for (int u = 1; u <= 3; ++u) {
    for (int v = 1; v <= 3; ++v) {
      for (int w = 1; w <= 3; ++w) {
        testing::LatticeOptions options{.degree = {u, v, w}, .extra = {1, 0, 1}};
        const Scene scene = MakeScene(testing::TorusMesh(7, 5), options, 0.15);
        largest_share = std::max(largest_share, ExpectCertified(scene, 2'000));
      }
    }
  }
  // Where one edge bends alone, its certificate is sharp.
  EXPECT_GT(largest_share, 0.9);
}

TEST(AdaptiveReference, CertifiesSliversAndDegenerateTriangles) {
  PolygonMesh mesh = testing::TriangleSoup(40, kSampleSeed);  // every fourth is a sliver
  mesh.corner_vertices[3] = mesh.corner_vertices[4];          // two equal corners
  mesh.positions[mesh.corner_vertices[6]] =                   // three corners on a line
      0.5 * mesh.positions[mesh.corner_vertices[7]] + 0.5 * mesh.positions[mesh.corner_vertices[8]];

  const Scene scene = MakeScene(std::move(mesh), {.degree = {3, 2, 2}, .extra = {2, 2, 2}}, 0.2);

  EXPECT_GT(ExpectCertified(scene, 10'000), 0.9);
}

// x of the lattice becomes the angle along an arc, z the distance from it.
std::vector<Vec3d> Bend(const LatticeStructure& structure, double angle) {
  std::vector<Vec3d> points = IdentityControlPoints(structure);
  const double begin = structure.frame.origin.x, length = structure.frame.edges[0].x;
  for (Vec3d& p : points) {
    const double phi = angle * ((p.x - begin) / length - 0.5), radius = length / angle - p.z;
    p = {radius * std::sin(phi), p.y, length / angle - radius * std::cos(phi)};
  }
  return points;
}

TEST(AdaptiveReference, CertifiesBendsToAHalfTurn) {
  for (const double degrees : {60.0, 120.0, 180.0}) {
    Scene scene =
        MakeScene(testing::TorusMesh(12, 8), {.degree = {3, 1, 2}, .extra = {3, 0, 0}}, 0);
    scene.control_points = Bend(scene.plan->structure, degrees * std::numbers::pi / 180);

    EXPECT_GT(ExpectCertified(scene, 10'000), 0.8) << degrees;
  }
}

// Control points move by three spacings: the surface passes through itself, and J changes its sign.
TEST(AdaptiveReference, CertifiesFolds) {
  const Scene scene = MakeScene(testing::TorusMesh(9, 6), {.degree = {2, 3, 1}}, 1.0);

  EXPECT_GT(ExpectCertified(scene, 3'000), 0.8);
}

TEST(AdaptiveReference, CertifiesRandomKnotsFramesAndPartsOutside) {
  for (uint32_t seed = 1; seed <= 10; ++seed) {
    const testing::RandomCase drawn = testing::DrawCase(seed);
    SCOPED_TRACE(::testing::Message() << "seed " << seed);

    ExpectCertified(MakeScene(drawn.mesh, drawn.options, 0.1), 2'000);
  }
}

TEST(AdaptiveReference, ALatticeAtRestNeedsNoPoints) {
  const Scene scene = MakeScene(testing::TorusMesh(10, 8), {.degree = {3, 3, 3}}, 0);
  const AdaptiveReference reference(scene.plan);

  const auto bounds = reference.Bounds(scene.control_points);
  const AdaptiveTessellation t = reference.Tessellate(bounds, 1e-12);

  EXPECT_LT(t.largest_error, 1e-13);
  EXPECT_EQ(std::count(t.edge_levels.begin(), t.edge_levels.end(), 0),
            static_cast<long>(scene.plan->edges.size()));
}

TEST(AdaptiveReference, PatchesOutsideFollowTheirNeighboursOnly) {
  const Scene scene = MakeScene(testing::TorusMesh(16, 12), {.scale = 0.6}, 0.3);
  const DeformPlan& plan = *scene.plan;
  ASSERT_GT(plan.outside_patches, 0u);
  ASSERT_GT(plan.seams.size(), 0u);
  const AdaptiveReference reference(scene.plan);

  const auto bounds = reference.Bounds(scene.control_points);
  const AdaptiveTessellation t = reference.Tessellate(bounds, 1e-3);

  int split_outside = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    if (plan.patches[p].box != plan.outside_box()) continue;
    EXPECT_EQ(t.errors[p], 0);
    for (size_t e = 0; e < 3; ++e) {
      EXPECT_EQ(bounds[p].edge[e], 0);
      const bool is_shared = plan.edges[plan.patches[p].edge[e]].seam != kNoIndex;
      if (!is_shared) {
        EXPECT_EQ(t.patterns[p].levels[e], 0) << "patch " << p;
      }
      split_outside += t.patterns[p].levels[e] > 0;
    }
  }
  EXPECT_GT(split_outside, 0);
}

TEST(AdaptiveReference, SaysWhatHoldsWhereLevelFiveDoesNotSuffice) {
  const Scene scene =
      MakeScene(testing::OneTriangle(), {.degree = {2, 2, 2}, .extra = {0, 0, 0}}, 0.4);
  const AdaptiveReference reference(scene.plan);

  const auto bounds = reference.Bounds(scene.control_points);
  const AdaptiveTessellation t = reference.Tessellate(bounds, 1e-9);

  EXPECT_EQ(t.edge_levels, (std::vector<uint8_t>{5, 5, 5}));
  EXPECT_GT(t.largest_error, 1e-9);
  ExpectCertified(scene, 1'000);

  // The bound along one edge is larger than the sum of the others, so that the error is largest in the middle of a
  // side (Lemma 1). All triangles are tried: of 1,024, random points would miss those of the largest error.
  const AdaptivePattern& pattern = AdaptivePattern::Get(t.patterns[0]);
  const DirectFfd ffd(*scene.plan, scene.control_points);
  double largest = 0;
  for (size_t triangle = 0; triangle < pattern.triangles.size(); ++triangle) {
    for (const auto& middle : {std::array{0.5, 0.5, 0.0}, {0.0, 0.5, 0.5}, {0.5, 0.0, 0.5}}) {
      largest = std::max(largest, ErrorAt(pattern, triangle, middle, ffd, 0));
    }
  }
  EXPECT_GT(largest, 0.95 * t.largest_error);
  EXPECT_LE(largest, t.largest_error);
}

}  // namespace
}  // namespace latticed
