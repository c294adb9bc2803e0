// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures of surfaces with vertex weights, under a turned lattice, and with both, compared with quadrature and samples of the
// definition, and with differences.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <tuple>
#include <utility>

#include "core/ffd/outside/outside_map.h"
#include "core/ffd/pick/patch_tree.h"
#include "core/measure/enclosed_volume.h"
#include "core/measure/kept_volume.h"
#include "core/measure/surface_area.h"
#include "core/measure/surface_bounds.h"
#include "core/measure/surface_closure.h"
#include "tests/core/measure/close_bounds.h"
#include "tests/core/measure/measured_patches.h"
#include "tests/core/measure/slopes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kMeasuredWeightsSeed = 63;

using Order = SurfaceMoments::Order;
using WeightedPlanPtr = std::shared_ptr<const DeformPlan>;

// About a third are 0 and a third are 1.
VertexWeights SomeWeights(const PolygonMesh& mesh) {
  std::mt19937 random(kMeasuredWeightsSeed);
  std::uniform_real_distribution<float> uniform(-1, 2);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  return std::make_shared<const std::vector<float>>(std::move(weights));
}

WeightedPlanPtr WeightedPlanOf(PolygonMesh mesh, const LatticeOptions& options,
                               VertexWeights weights = nullptr) {
  if (weights == nullptr) weights = SomeWeights(mesh);
  const auto structure = MakeStructure(mesh.ComputeBounds(), options);
  return *MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure, {}, NeverStop,
                   std::move(weights));
}

VertexWeights ConstantWeights(const PolygonMesh& mesh, float weight) {
  return std::make_shared<const std::vector<float>>(mesh.positions.size(), weight);
}

EnclosedCentroid CentroidOf(const WeightedPlanPtr& plan, std::span<const Vec3d> points) {
  if (plan->is_weighted() || !plan->turned.empty()) return *MeasureCentroidByPatches(*plan, points);
  return MeasureCentroid(**SurfaceMoments::Make(plan, Order::kCentroid), points);
}

// Of all lattices of a plan.
std::vector<Vec3d> JitterAll(const DeformPlan& plan, double amount, uint32_t seed) {
  std::vector<Vec3d> points = Jitter(plan.structure, amount, seed);
  for (const TurnedLattice& lattice : plan.turned) {
    const std::vector<Vec3d> own = Jitter(lattice.structure, amount, ++seed);
    points.insert(points.end(), own.begin(), own.end());
  }
  return points;
}

void ExpectVolumeWithoutTables(const WeightedPlanPtr& plan, double jitter) {
  const auto moments = *SurfaceMoments::Make(plan, Order::kVolume);
  ASSERT_FALSE(moments->has_weights());
  EXPECT_TRUE(moments->boxes().empty());
  const auto points = Jitter(plan->structure, jitter, 3);
  EXPECT_NEAR(MeasureVolume(*moments, points).volume / MeasurePatches(*plan, points).volume, 1,
              1e-12);
}

enum class Surface { kWeighted, kTurned, kBoth };
void PrintTo(Surface surface, std::ostream* out) {
  constexpr std::array kNames{"weighted", "turned", "both"};
  *out << kNames[static_cast<size_t>(surface)];
}

class MeasuredDegrees : public ::testing::TestWithParam<std::tuple<int, Surface>> {
 protected:
  static int Mix() { return std::get<0>(GetParam()); }
  static WeightedPlanPtr Plan() {
    const int n = Mix();
    const LatticeOptions options{.degree = {1 + n % 3, 1 + n / 3 % 3, 1 + n / 9},
                                 .extra = {1, 1, 1},
                                 .knots = KnotKind::kNonUniform,
                                 .mirrored = n % 2 == 1};
    if (std::get<1>(GetParam()) == Surface::kWeighted)
      return WeightedPlanOf(TorusMesh(7, 5), options);
    const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(7, 5));
    LatticeOptions turned = options;
    std::swap(turned.degree[0], turned.degree[2]);
    turned.scale = 2.2;
    turned.turn = 0.6;
    const std::array structures{MakeStructure(mesh->ComputeBounds(), options),
                                MakeStructure(mesh->ComputeBounds(), turned)};
    const bool is_weighted = std::get<1>(GetParam()) == Surface::kBoth;
    return *MakePlan(mesh, structures[0], {}, NeverStop, is_weighted ? SomeWeights(*mesh) : nullptr,
                     std::span(structures).subspan(1));
  }
};

TEST_P(MeasuredDegrees, VolumeAndCentroidMatchQuadrature) {
  const auto plan = Plan();
  const auto points = JitterAll(*plan, 0.08, 3);

  const auto moments = *SurfaceMoments::Make(plan, Order::kVolume);
  EXPECT_EQ(moments->has_weights(), std::get<1>(GetParam()) == Surface::kWeighted);

  const auto got = CentroidOf(plan, points);
  const auto volume = MeasureVolume(*moments, points);

  const MeasuredPatches want = MeasurePatches(*plan, points);
  EXPECT_NEAR(volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(Norm(got.volume.gradient[i] - volume.gradient[i]), 0, 1e-13);
  }
}

TEST(WeightedMeasures, FewPatchesOfABoxHaveNoTables) {
  const PolygonMesh mesh = CubeMesh(1);
  const auto plan = WeightedPlanOf(mesh, {.degree = {2, 2, 2}, .extra = {12, 12, 12}},
                                   ConstantWeights(mesh, 0.5f));
  ExpectVolumeWithoutTables(plan, 0.05);
}

// Tables of 1,075 boxes of degrees (3, 3, 3) would take more.
TEST(WeightedMeasures, TablesOfManyBoxesWouldTakeTooMuchMemory) {
  const PolygonMesh mesh = TorusMesh(60, 30);
  const auto plan_of = [&](int inner) {
    return WeightedPlanOf(mesh, {.degree = {3, 3, 3}, .extra = {inner, inner, inner}});
  };
  const auto few = plan_of(8), many = plan_of(20);
  const auto most = SurfaceMoments::kMostWeightedBytes;
  const size_t bytes = SurfaceMoments::BytesFor(*few, Order::kVolume);
  EXPECT_GT(bytes, most / 10);
  EXPECT_LT(bytes, most + 100'000);
  EXPECT_LT(SurfaceMoments::BytesFor(*many, Order::kVolume), 100'000u);

  std::vector<uint32_t> filled;
  for (const Patch& patch : many->patches) filled.push_back(patch.box);
  std::ranges::sort(filled);
  const auto boxes =
      static_cast<size_t>(std::unique(filled.begin(), filled.end()) - filled.begin());
  ASSERT_GT(boxes, 1'075u);
  ASSERT_GE(many->patches.size(), 4 * boxes);
  ExpectVolumeWithoutTables(many, 0.02);
}

// What lies outside the frame rests, and so does the surface at its faces.
TEST(WeightedMeasures, VolumePartlyOutsideMatchesQuadrature) {
  const PolygonMesh mesh = TorusMesh(30, 20, {40, -30, 20});
  const auto plan = WeightedPlanOf(mesh, {.degree = {2, 1, 3}, .extra = {3, 3, 3}, .scale = 0.8});
  ASSERT_GT(plan->outside_patches, 0u);
  const auto moments = *SurfaceMoments::Make(plan, Order::kVolume);
  ASSERT_TRUE(moments->has_weights());
  std::vector<Vec3d> points = plan->identity_points;
  const double rest = RestVolume(*moments);
  EXPECT_NEAR(rest / MeasurePatches(*plan, points).volume, 1, 1e-12);
  const LatticeStructure& s = plan->structure;
  const auto moves = Jitter(s, 0.08, 7);
  for (int k = 1; k + 1 < s.size[2]; ++k) {
    for (int j = 1; j + 1 < s.size[1]; ++j) {
      for (int i = 1; i + 1 < s.size[0]; ++i) {
        const auto index = static_cast<size_t>(s.Index(i, j, k));
        points[index] = moves[index];
      }
    }
  }
  ASSERT_EQ(CountTornEdges(*plan, points), 0u);
  const double volume = MeasureVolume(*moments, points).volume;
  EXPECT_GT(std::abs(volume / rest - 1), 1e-5);
  EXPECT_NEAR(volume / MeasurePatches(*plan, points).volume, 1, 1e-12);
}

TEST_P(MeasuredDegrees, GradientsMatchDifferences) {
  const auto plan = Plan();
  const auto points = JitterAll(*plan, 0.08, 4);
  const auto moves = JitterAll(*plan, 0.5, 5);
  const auto at = [&](double h) { return CentroidOf(plan, Moved(points, h, moves)); };

  const auto got = at(0);

  double volume_slope = 0;
  Vec3d centroid_slope;
  for (size_t i = 0; i < points.size(); ++i) {
    volume_slope += Dot(got.volume.gradient[i], moves[i]);
    for (int c = 0; c < 3; ++c) {
      centroid_slope += moves[i][c] * got.gradient[i][static_cast<size_t>(c)];
    }
  }
  // On a line V is a cubic.
  EXPECT_NEAR(CubicSlope([&](double h) { return at(h).volume.volume; }, 0.05), volume_slope, 1e-11);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(CubicSlope([&](double h) { return at(h).centroid[c]; }, 1e-3), centroid_slope[c],
                1e-8);
  }
}

TEST_P(MeasuredDegrees, AreaKeepsItsToleranceAndItsGradientMatchesDifferences) {
  const auto plan = Plan();
  const auto points = JitterAll(*plan, 0.08, 9);
  const double want = MeasurePatches(*plan, points, 24).area;
  for (const double tolerance : {1e-2, 1e-6, 1e-10}) {
    const auto got = *MeasureArea(*plan, points, tolerance, false);
    EXPECT_NEAR(got.area / want, 1, tolerance);
    EXPECT_LE(got.error, tolerance * got.area);
  }
  if (Mix() % 5 != 0) return;  // differences take long
  const auto moves = JitterAll(*plan, 0.5, 10);
  const auto got = *MeasureArea(*plan, points, 1e-10, true);
  double slope = 0;
  for (size_t i = 0; i < points.size(); ++i) slope += Dot(got.gradient[i], moves[i]);
  const double by_differences = CubicSlope(
      [&](double h) { return MeasureArea(*plan, Moved(points, h, moves), 1e-12, false)->area; },
      1e-3);
  EXPECT_NEAR(slope, by_differences, 1e-8 * std::abs(by_differences) + 1e-8);
}

TEST_P(MeasuredDegrees, BoundsHoldTheSurfaceClosely) {
  const auto plan = Plan();
  const auto points = JitterAll(*plan, 0.2, 11);
  ExpectCloseBounds(*plan, points);
}

INSTANTIATE_TEST_SUITE_P(All, MeasuredDegrees,
                         ::testing::Combine(::testing::Range(0, 27),
                                            ::testing::Values(Surface::kWeighted, Surface::kTurned,
                                                              Surface::kBoth)));

TEST(WeightedMeasures, OfWeightZeroAreThoseAtRest) {
  const auto plan = WeightedPlanOf(CubeMesh(3), {.scale = 1.5}, ConstantWeights(CubeMesh(3), 0));
  const auto got = CentroidOf(plan, Jitter(plan->structure, 0.2, 6));
  EXPECT_NEAR(got.volume.volume, 1, 1e-14);
  EXPECT_NEAR(Norm(got.centroid - Vec3d{0.5, 0.5, 0.5}), 0, 1e-14);
  for (const Vec3d g : got.volume.gradient) EXPECT_EQ(g, Vec3d());
}

TEST(WeightedMeasures, OfWeightOneAreThoseWithoutWeights) {
  const PolygonMesh mesh = TorusMesh(20, 12);
  const auto plan = WeightedPlanOf(mesh, {.degree = {3, 2, 3}}, ConstantWeights(mesh, 1));
  const auto structure = MakeStructure(mesh.ComputeBounds(), {.degree = {3, 2, 3}});
  const WeightedPlanPtr plain = *MakePlan(std::make_shared<const PolygonMesh>(mesh), structure);
  const auto points = Jitter(structure, 0.1, 7);

  const auto got = CentroidOf(plan, points), want = CentroidOf(plain, points);

  EXPECT_NEAR(got.volume.volume / want.volume.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(Norm(got.volume.gradient[i] - want.volume.gradient[i]), 0, 1e-12);
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(Norm(got.gradient[i][k] - want.gradient[i][k]), 0, 1e-12);
    }
  }
}

TEST(WeightedMeasures, CountWhatLiesOutsideTheFrame) {
  const auto plan = WeightedPlanOf(TorusMesh(16, 8, {5, 0, 0}),
                                   {.extra = {3, 3, 3}, .scale = 0.8, .shift = {0.3, 0, 0}});
  ASSERT_GT(plan->outside_patches, 0u);
  auto points = IdentityControlPoints(plan->structure);
  points[static_cast<size_t>(plan->structure.Index(2, 2, 2))] += Vec3d{0.1, 0.2, 0.3};
  ASSERT_EQ(CountTornEdges(*plan, points), 0u);

  const auto got = CentroidOf(plan, points);

  const MeasuredPatches want = MeasurePatches(*plan, points);
  EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
}

TEST(WeightedMeasures, AVolumeIsKept) {
  for (int degree = 1; degree <= 3; ++degree) {
    const auto plan =
        WeightedPlanOf(TorusMesh(20, 12), {.degree = {degree, degree, degree}, .extra = {2, 2, 2}});
    const auto moments = *SurfaceMoments::Make(plan, Order::kVolume);
    std::vector<Vec3d> points = plan->identity_points;
    std::vector<bool> named(points.size());
    for (size_t i = 0; i < points.size() / 2; ++i) {
      points[i] += Vec3d{0.2, 0.1 * std::sin(static_cast<double>(i)), -0.3};
      named[i] = true;
    }
    const auto error = [&] {
      return std::abs(MeasurePatches(*plan, points).volume / RestVolume(*moments) - 1);
    };
    ASSERT_GT(error(), 1e-3);

    const int steps = *KeepVolume(*moments, {}, nullptr, named, points);

    EXPECT_LE(steps, kMostVolumeSteps);
    EXPECT_LE(error(), 2e-12);
  }
}

// The axis is one of the edited lattice's.
void ExpectKeptAlongAnAxisOfATurnedLattice(bool is_weighted) {
  const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(20, 12));
  const LatticeOptions turned_options{.scale = 2, .turn = 0.7};
  const std::array structures{MakeStructure(mesh->ComputeBounds(), {}),
                              MakeStructure(mesh->ComputeBounds(), turned_options)};
  const auto plan =
      *MakePlan(mesh, structures[0], {}, NeverStop, is_weighted ? SomeWeights(*mesh) : nullptr,
                std::span(structures).subspan(1));
  OutsideMap map(structures[1]);
  map.PlaceAmong(plan->turned[0].first_point,
                 std::make_shared<const std::vector<Vec3d>>(plan->identity_points));
  const auto moments = *SurfaceMoments::Make(plan, Order::kVolume);
  EXPECT_TRUE(moments->is_by_patches());
  std::vector<Vec3d> points = IdentityControlPoints(structures[1]);
  std::vector<bool> named(points.size());
  const size_t moved = points.size() / 2;
  points[moved] += Vec3d{0.3, 0.2, -0.4};
  named[moved] = true;
  const std::vector<Vec3d> before = points;

  ASSERT_OK(KeepVolume(*moments, {.axis = 1}, nullptr, named, points, &map));

  const double volume = MeasurePatches(*plan, map.Continue(points)).volume;
  EXPECT_NEAR(volume / RestVolume(*moments), 1, 1e-12);
  const Vec3d axis = structures[1].frame.edges[1] / Norm(structures[1].frame.edges[1]);
  double most = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3d move = points[i] - before[i];
    EXPECT_LE(Norm(Cross(move, axis)), 1e-13);
    most = std::max(most, Norm(move));
  }
  EXPECT_GT(most, 1e-4);
}

TEST(TurnedMeasures, TheVolumeIsKeptAlongAnAxisOfTheTurnedLattice) {
  ExpectKeptAlongAnAxisOfATurnedLattice(false);
  ExpectKeptAlongAnAxisOfATurnedLattice(true);
}

// Some patches are in the turned lattice alone, others in the plan's own one too.
TEST(TurnedMeasures, WithWeightsCountWhatOnlyATurnedLatticeReaches) {
  const auto mesh = std::make_shared<const PolygonMesh>(TorusMesh(16, 10));
  const std::array structures{
      MakeStructure(mesh->ComputeBounds(), {.extra = {3, 3, 3}, .scale = 0.8}),
      MakeStructure(mesh->ComputeBounds(), {.degree = {1, 3, 2}, .scale = 2, .turn = 0.7})};
  const auto plan = *MakePlan(mesh, structures[0], {}, NeverStop, SomeWeights(*mesh),
                              std::span(structures).subspan(1));
  ASSERT_GT(plan->outside_patches, 0u);
  std::vector<Vec3d> points = JitterAll(*plan, 0.08, 12);
  for (size_t i = 0; i < plan->turned[0].first_point; ++i) points[i] = plan->identity_points[i];
  points[static_cast<size_t>(structures[0].Index(2, 2, 2))] += Vec3d{0.1, 0.2, 0.3};
  ASSERT_EQ(CountTornEdges(*plan, points), 0u);

  const auto got = CentroidOf(plan, points);
  const auto area = *MeasureArea(*plan, points, 1e-8, false);

  const MeasuredPatches want = MeasurePatches(*plan, points);
  EXPECT_NEAR(got.volume.volume / want.volume, 1, 1e-12);
  EXPECT_NEAR(Norm(got.centroid - want.centroid), 0, 1e-12);
  EXPECT_NEAR(area.area / want.area, 1, 1e-8);
  ExpectCloseBounds(*plan, points);
}

TEST(WeightedClosure, VerticesOfOtherWeightsAreNotOne) {
  PolygonMesh mesh = CubeMesh(1);
  // Another vertex at the place of the first, for one face.
  mesh.positions.push_back(mesh.positions[mesh.corner_vertices[0]]);
  mesh.corner_vertices[0] = static_cast<uint32_t>(mesh.positions.size() - 1);
  std::vector<float> weights(mesh.positions.size(), 0.5f);
  const auto shared = [&] { return std::make_shared<const std::vector<float>>(weights); };

  EXPECT_EQ(CountBorderEdges(mesh, shared()), 0u);
  weights.back() = 0.25f;
  EXPECT_EQ(CountBorderEdges(mesh, shared()), 4u);
}

TEST(WeightedClosure, WhatRestsIsNotTorn) {
  const PolygonMesh mesh = TorusMesh(16, 8);
  const LatticeOptions options{.extra = {3, 3, 3}, .scale = 0.8};
  const auto torn = [&](VertexWeights weights) {
    const auto plan = WeightedPlanOf(mesh, options, std::move(weights));
    auto points = IdentityControlPoints(plan->structure);
    for (Vec3d& p : points) p += Vec3d{0, 0, 0.1};
    return CountTornEdges(*plan, points);
  };
  EXPECT_GT(torn(ConstantWeights(mesh, 0.1f)), 0u);
  EXPECT_EQ(torn(ConstantWeights(mesh, 0)), 0u);
}

}  // namespace
}  // namespace latticed::testing
