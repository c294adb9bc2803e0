// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Volume, centroid and their gradients, compared with quadrature of the definition on every patch, with known bodies,
// and with differences.
#include "core/measure/enclosed_volume.h"

#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/measure/surface_closure.h"
#include "core/mesh/sample_meshes.h"
#include "tests/core/measure/measured_patches.h"
#include "tests/core/measure/slopes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using Order = SurfaceMoments::Order;

std::shared_ptr<const DeformPlan> PlanOf(PolygonMesh mesh, const LatticeOptions& options) {
  const auto structure = MakeStructure(mesh.ComputeBounds(), options);
  return *MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
}

std::shared_ptr<const SurfaceMoments> MomentsOf(std::shared_ptr<const DeformPlan> plan,
                                                Order order) {
  return *SurfaceMoments::Make(std::move(plan), order);
}

// Directions with entries in [-1, 1], one for each control point.
std::vector<Vec3d> RandomMoves(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Vec3d> moves(count);
  for (Vec3d& m : moves) m = {unit(random), unit(random), unit(random)};
  return moves;
}

class DegreesTest : public ::testing::TestWithParam<int> {
 protected:
  static std::array<int, 3> degree() {
    return {1 + GetParam() % 3, 1 + GetParam() / 3 % 3, 1 + GetParam() / 9};
  }
};

TEST_P(DegreesTest, MatchesQuadratureOfThePatches) {
  const auto plan = PlanOf(TorusMesh(7, 5), {.degree = degree(),
                                             .extra = {1, 2, 1},
                                             .knots = KnotKind::kNonUniform,
                                             .shear = 0.2,
                                             .mirrored = GetParam() % 2 == 1});
  const auto points = Jitter(plan->structure, 0.08, 3);

  const auto got = MeasureCentroid(*MomentsOf(plan, Order::kCentroid), points);
  const auto volume = MeasureVolume(*MomentsOf(plan, Order::kVolume), points);

  const MeasuredPatches want = MeasurePatches(*plan, points);
  EXPECT_NEAR(volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(Norm(got.volume.gradient[i] - volume.gradient[i]), 0, 1e-13);
  }
}

TEST_P(DegreesTest, GradientsMatchDifferences) {
  const auto plan = PlanOf(TorusMesh(7, 5), {.degree = degree(), .extra = {1, 1, 1}});
  const auto points = Jitter(plan->structure, 0.08, 4);
  const auto moves = RandomMoves(points.size(), 5);
  const auto moments = MomentsOf(plan, Order::kCentroid);
  const auto at = [&](double h) { return MeasureCentroid(*moments, Moved(points, h, moves)); };

  const auto got = at(0);

  double volume_slope = 0;
  Vec3d centroid_slope;
  for (size_t i = 0; i < points.size(); ++i) {
    volume_slope += Dot(got.volume.gradient[i], moves[i]);
    for (int c = 0; c < 3; ++c) {
      centroid_slope += moves[i][c] * got.gradient[i][static_cast<size_t>(c)];
    }
  }
  EXPECT_NEAR(CubicSlope([&](double h) { return at(h).volume.volume; }, 0.05), volume_slope, 1e-12);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(CubicSlope([&](double h) { return at(h).centroid[c]; }, 1e-3), centroid_slope[c],
                1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(All, DegreesTest, ::testing::Range(0, 27));

TEST(EnclosedVolumeTest, OfABoxAtRestIsKnown) {
  const auto plan = PlanOf(CubeMesh(3), {.scale = 1.5});
  const auto points = IdentityControlPoints(plan->structure);

  const auto got = MeasureCentroid(*MomentsOf(plan, Order::kCentroid), points);

  EXPECT_NEAR(got.volume.volume, 1, 1e-14);
  EXPECT_NEAR(Norm(got.centroid - Vec3d{0.5, 0.5, 0.5}), 0, 1e-14);
}

TEST(EnclosedVolumeTest, FollowsTheAffineLaw) {
  const auto plan = PlanOf(TorusMesh(20, 12), {.degree = {3, 2, 3}});
  auto points = Jitter(plan->structure, 0.1, 6);
  const auto moments = MomentsOf(plan, Order::kCentroid);
  const auto before = MeasureCentroid(*moments, points);
  const Vec3d a{1.2, 0.3, -0.4}, b{0.1, -0.9, 0.2}, c{0.5, 0.2, 1.5}, shift{10, 20, -30};
  const auto map = [&](Vec3d p) { return p.x * a + p.y * b + p.z * c + shift; };
  for (Vec3d& p : points) p = map(p);

  const auto after = MeasureCentroid(*moments, points);

  const double determinant = Dot(a, Cross(b, c));
  EXPECT_LT(determinant, 0);
  EXPECT_NEAR(after.volume.volume / (determinant * before.volume.volume), 1, 1e-12);
  EXPECT_NEAR(Norm(after.centroid - map(before.centroid)), 0, 1e-11);
}

TEST(EnclosedVolumeTest, OfClosedSampleMeshesMatchesQuadrature) {
  for (const char* name : {"vase", "knot", "gear", "beam"}) {
    SCOPED_TRACE(name);
    PolygonMesh mesh = *MakeSampleMesh(name, 1);
    ASSERT_EQ(CountBorderEdges(mesh), 0u);
    const auto plan = PlanOf(std::move(mesh), {.extra = {3, 3, 3}});
    const auto points = Jitter(plan->structure, 0.05, 7);

    const auto got = MeasureCentroid(*MomentsOf(plan, Order::kCentroid), points);

    const MeasuredPatches want = MeasurePatches(*plan, points, 10);
    EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
    EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
  }
}

TEST(EnclosedVolumeTest, CountsWhatLiesOutsideTheFrame) {
  const auto plan =
      PlanOf(TorusMesh(16, 8, {5, 0, 0}), {.extra = {3, 3, 3}, .scale = 0.8, .shift = {0.3, 0, 0}});
  ASSERT_GT(plan->outside_patches, 0u);
  auto points = IdentityControlPoints(plan->structure);
  points[static_cast<size_t>(plan->structure.Index(2, 2, 2))] += Vec3d{0.1, 0.2, 0.3};
  ASSERT_EQ(CountTornEdges(*plan, points), 0u);

  const auto got = MeasureCentroid(*MomentsOf(plan, Order::kCentroid), points);

  const MeasuredPatches want = MeasurePatches(*plan, points);
  EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
}

TEST(SurfaceClosureTest, CountsBorders) {
  EXPECT_EQ(CountBorderEdges(FlatGrid(4, 0)), 16u);
  EXPECT_EQ(CountBorderEdges(OneTriangle()), 3u);
  EXPECT_EQ(CountBorderEdges(CubeMesh(2)), 0u);
  PolygonMesh turned = CubeMesh(1);
  std::swap(turned.corner_vertices[0],
            turned.corner_vertices[2]);  // one face against its neighbours
  EXPECT_EQ(CountBorderEdges(turned), 4u);
}

TEST(SurfaceClosureTest, CountsTornEdges) {
  const auto plan = PlanOf(TorusMesh(16, 8), {.extra = {3, 3, 3}, .scale = 0.8});
  auto points = IdentityControlPoints(plan->structure);
  EXPECT_EQ(CountTornEdges(*plan, points), 0u);
  for (Vec3d& p : points) p += Vec3d{0, 0, 0.1};

  const uint64_t torn = CountTornEdges(*plan, points);

  uint64_t seams = 0;
  for (const PlanEdge& edge : plan->edges) seams += edge.seam != kNoIndex ? 1 : 0;
  EXPECT_EQ(torn, seams);
  EXPECT_GT(torn, 0u);
  const auto status = CheckClosed(0, torn);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(error::DetailsOf(status).metadata.at("torn_edges"), std::to_string(torn));
}

TEST(SurfaceMomentsTest, TellTheirBytesAndStop) {
  const auto plan = PlanOf(TorusMesh(16, 8), {});
  const auto moments = MomentsOf(plan, Order::kVolume);
  EXPECT_EQ(moments->MemoryBytes(), SurfaceMoments::BytesFor(*plan, Order::kVolume));
  EXPECT_THAT(SurfaceMoments::Make(plan, Order::kVolume, [] { return absl::CancelledError(); }),
              StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace latticed::testing
