// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Area and bounds, compared with known bodies, with dense samples of the definition, and with differences.
#include <cmath>
#include <memory>
#include <utility>

#include "core/ffd/pick/patch_tree.h"
#include "core/measure/surface_area.h"
#include "core/measure/surface_bounds.h"
#include "tests/core/measure/close_bounds.h"
#include "tests/core/measure/measured_patches.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

std::shared_ptr<const DeformPlan> PlanFor(PolygonMesh mesh, const LatticeOptions& options) {
  const auto structure = MakeStructure(mesh.ComputeBounds(), options);
  return *MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure);
}

class AreaDegreesTest : public ::testing::TestWithParam<int> {};

TEST_P(AreaDegreesTest, KeepsItsToleranceAndItsGradientMatchesDifferences) {
  const int n = GetParam();
  const auto plan = PlanFor(TorusMesh(7, 5), {.degree = {1 + n % 3, 1 + n / 3 % 3, 1 + n / 9},
                                              .extra = {1, 1, 1},
                                              .knots = KnotKind::kNonUniform});
  const auto points = Jitter(plan->structure, 0.08, 9);
  const auto moves = Jitter(plan->structure, 0.5, 10);
  const double want = MeasurePatches(*plan, points, 24).area;
  const auto moved = [&](double h) {
    auto result = points;
    for (size_t i = 0; i < result.size(); ++i) result[i] += h * moves[i];
    return MeasureArea(*plan, result, 1e-12, false)->area;
  };

  for (const double tolerance : {1e-2, 1e-6, 1e-10}) {
    const auto got = *MeasureArea(*plan, points, tolerance, false);
    EXPECT_NEAR(got.area / want, 1, tolerance);
    EXPECT_LE(got.error, tolerance * got.area);
    EXPECT_TRUE(got.gradient.empty());
  }
  if (n % 5 != 0) return;  // differences take long
  const auto got = *MeasureArea(*plan, points, 1e-10, true);
  double slope = 0;
  for (size_t i = 0; i < points.size(); ++i) slope += Dot(got.gradient[i], moves[i]);
  constexpr double kStep = 1e-3;
  const double by_differences =
      (8 * (moved(kStep) - moved(-kStep)) - (moved(2 * kStep) - moved(-2 * kStep))) / (12 * kStep);
  EXPECT_NEAR(slope, by_differences, 1e-8 * std::abs(by_differences) + 1e-8);
}

INSTANTIATE_TEST_SUITE_P(All, AreaDegreesTest, ::testing::Range(0, 27));

TEST(SurfaceAreaTest, OfABoxAtRestIsKnownAndOutsideCounts) {
  const auto plan = PlanFor(CubeMesh(3), {.scale = 0.7});
  ASSERT_GT(plan->outside_patches, 0u);
  const auto got = *MeasureArea(*plan, IdentityControlPoints(plan->structure), 1e-6, true);
  EXPECT_NEAR(got.area, 6, 1e-12);
}

TEST(SurfaceAreaTest, OfACollapsedSurfaceIsNothing) {
  const auto plan = PlanFor(TorusMesh(7, 5), {});
  const std::vector<Vec3d> points(plan->identity_points.size(), Vec3d{1, 2, 3});
  const auto got = *MeasureArea(*plan, points, 1e-6, true);
  EXPECT_EQ(got.area, 0);
  for (const Vec3d& g : got.gradient) EXPECT_EQ(g, Vec3d{});
}

TEST(SurfaceAreaTest, Stops) {
  const auto plan = PlanFor(TorusMesh(7, 5), {});
  EXPECT_THAT(
      MeasureArea(*plan, plan->identity_points, 1e-6, false, [] { return absl::CancelledError(); }),
      StatusIs(absl::StatusCode::kCancelled));
}

class BoundsDegreesTest : public ::testing::TestWithParam<int> {};

TEST_P(BoundsDegreesTest, HoldTheSurfaceClosely) {
  const int n = GetParam();
  const auto plan = PlanFor(TorusMesh(7, 5), {.degree = {1 + n % 3, 1 + n / 3 % 3, 1 + n / 9},
                                              .extra = {1, 1, 1},
                                              .scale = n % 2 == 0 ? 1.1 : 0.9});
  const auto points = Jitter(plan->structure, 0.2, 11);
  ExpectCloseBounds(*plan, points);
}

INSTANTIATE_TEST_SUITE_P(All, BoundsDegreesTest, ::testing::Range(0, 27));

// z = 1 - (x - 1/3)^2 - (y - 1/3)^2 over a flat grid: its top is inside a patch.
TEST(SurfaceBoundsTest, FindATopInsideAPatch) {
  const auto plan = PlanFor(FlatGrid(2, 0.5), {.extra = {0, 0, 0}, .scale = 1});
  const LatticeStructure& s = plan->structure;
  std::vector<Vec3d> points = IdentityControlPoints(s);
  // The quadratic (t - 1/3)^2 has the Bezier ordinates 1/9, -2/9, 4/9 on [0, 1].
  constexpr double kOrdinates[] = {1.0 / 9, -2.0 / 9, 4.0 / 9};
  for (int k = 0; k < s.size[2]; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        points[static_cast<size_t>(s.Index(i, j, k))].z = 1 - kOrdinates[i] - kOrdinates[j];
      }
    }
  }

  const Bounds got = *MeasureBounds(*plan, PatchTree(*plan), points);

  EXPECT_NEAR(got.max.z, 1, 1e-9);
  EXPECT_NEAR(got.min.z, 1 - 8.0 / 9, 1e-9);
  EXPECT_NEAR(got.max.x, 1, 1e-9);
}

}  // namespace
}  // namespace latticed::testing
