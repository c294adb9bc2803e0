// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds of surfaces under lattices that are turned against each other, against the definition of J on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/folds/fold_certifier.h"
#include "core/folds/turned_determinant.h"
#include "tests/core/folds/turned_fold_fixtures.h"

namespace latticed {
namespace {

constexpr uint32_t kTurnedFoldSeed = 67;

using testing::DrawTurned;
using testing::ExpectDeterminantsOfTheDefinition;
using testing::ExpectReportsThatAgreeWithSamples;
using testing::JitterAll;
using testing::LatticeOptions;
using testing::PlanTurned;
using testing::ReportOfTurned;
using testing::TorusMesh;
using testing::TurnedFolds;
using testing::Weights;

TEST(TurnedDeterminant, IsTheDefinitionsOnEveryPatch) {
  std::mt19937 random(kTurnedFoldSeed);
  for (uint32_t mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(::testing::Message() << "mix " << mix << ", seed " << kTurnedFoldSeed);
    const TurnedFolds scene = DrawTurned(mix, mix % 2 == 0);
    const auto points = JitterAll(scene, 0.4, kTurnedFoldSeed + mix);
    TurnedPatches patches(*scene.plan, points);
    ASSERT_NO_FATAL_FAILURE(
        ExpectDeterminantsOfTheDefinition(*scene.plan, points, patches, 1e-7, random));
  }
}

// Far from the origin, control points lose digits, but J and its slack depend on their differences alone.
TEST(TurnedDeterminant, DoesNotDependOnWhereTheLatticesGo) {
  const TurnedFolds scene = DrawTurned(13, true);
  std::vector<Vec3d> points = JitterAll(scene, 0.2, kTurnedFoldSeed);
  BernsteinTriangle here, there;
  TurnedPatches before(*scene.plan, points);
  std::vector<Vec3d> moved = points;
  for (Vec3d& p : moved) p += Vec3d{1 << 20, 1 << 20, -(1 << 20)};
  TurnedPatches after(*scene.plan, moved);
  for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
    const double slack = before.MakeDeterminant(p, here);
    EXPECT_NEAR(after.MakeDeterminant(p, there), slack, 1e-6 * slack);
    EXPECT_NEAR(here.Least(), there.Least(), 1e-6);
  }
}

TEST(TurnedFolds, ReportsAgreeWithSamplesOfTheDefinition) {
  ExpectReportsThatAgreeWithSamples(Weights::kNone);
}

// The witness of a fold is on a patch of its box, and folded by the definition.
TEST(TurnedFolds, AWitnessIsFolded) {
  const TurnedFolds scene = DrawTurned(13, true);
  const DeformPlan& plan = *scene.plan;
  const auto points = JitterAll(scene, 0.5, kTurnedFoldSeed);
  const FoldReport report = ReportOfTurned(scene.plan, points);
  ASSERT_GT(report.Count(FoldState::kFolded), 3u);
  EXPECT_EQ(report.places.back().place, kOutsidePlace);
  for (const FoldedBox& place : report.places) {
    const auto j = EvaluateWorld(plan, points, place.rest_point).jacobian;
    EXPECT_NEAR(Dot(j[0], Cross(j[1], j[2])), place.determinant, 1e-7) << "box " << place.box;
    Bounds bounds;
    for (uint32_t p = plan.box_patches[place.box]; p < plan.box_patches[place.box + 1]; ++p) {
      for (const uint32_t v : plan.patches[p].vertex) bounds.Extend(plan.vertices[v].world);
    }
    EXPECT_EQ(Max(Min(place.rest_point, bounds.max), bounds.min), place.rest_point);
  }
}

// Both contain all of the mesh.
TurnedFolds TwoAround() {
  return PlanTurned(TorusMesh(9, 6),
                    std::vector<LatticeOptions>{{.scale = 2.5}, {.scale = 2.5, .turn = 0.7}});
}

// The displacements are those of linear maps: d0 and d1 times x, along x.
std::vector<Vec3d> StretchedBy(const TurnedFolds& scene, double d0, double d1) {
  std::vector<Vec3d> points = scene.plan->identity_points;
  const auto own = static_cast<size_t>(scene.structures[0].control_point_count());
  for (size_t i = 0; i < points.size(); ++i) points[i].x += (i < own ? d0 : d1) * points[i].x;
  return points;
}

TEST(TurnedFolds, LatticesThatFoldAloneMayNotFoldTogether) {
  const TurnedFolds scene = TwoAround();
  EXPECT_TRUE(ReportOfTurned(scene.plan, scene.plan->identity_points).certified());
  EXPECT_TRUE(ReportOfTurned(scene.plan, StretchedBy(scene, -2, 2)).certified());
  EXPECT_TRUE(ReportOfTurned(scene.plan, StretchedBy(scene, 3, -3.9)).certified());
}

TEST(TurnedFolds, LatticesThatDoNotFoldAloneMayFoldTogether) {
  const TurnedFolds scene = TwoAround();
  for (const auto& [d0, d1] : {std::pair{-0.6, 0.0}, {0.0, -0.6}}) {
    EXPECT_TRUE(ReportOfTurned(scene.plan, StretchedBy(scene, d0, d1)).certified());
  }
  const FoldReport report = ReportOfTurned(scene.plan, StretchedBy(scene, -0.6, -0.6));
  EXPECT_GT(report.boxes, 0u);
  EXPECT_EQ(report.Count(FoldState::kFolded), report.boxes);
  for (const FoldedBox& place : report.places) EXPECT_NEAR(place.determinant, -0.2, 1e-11);
}

// The plan's own lattice is around one half of the torus. The turned one is around the other half, or nowhere near.
TEST(TurnedFolds, TheOutsideBoxCountsWhereATurnedLatticeReachesIt) {
  for (const double x : {0.5, 5.0}) {
    const TurnedFolds scene =
        PlanTurned(TorusMesh(12, 6),
                   std::vector<LatticeOptions>{{.scale = 0.6, .shift = {-0.5, 0, 0}},
                                               {.scale = 0.6, .turn = 0.3, .shift = {x, 0, 0}}});
    const DeformPlan& plan = *scene.plan;
    uint64_t boxes = 0;
    for (size_t b = 0; b < plan.outside_box(); ++b) {
      boxes += plan.box_patches[b + 1] > plan.box_patches[b] ? 1u : 0u;
    }
    std::vector<Vec3d> points = plan.identity_points;
    for (size_t i = plan.turned[0].first_point; i < points.size(); ++i) points[i].z *= -1;

    const FoldReport report = ReportOfTurned(scene.plan, points);

    if (x > 1) {
      EXPECT_EQ(report, FoldReport{.boxes = boxes});
      continue;
    }
    EXPECT_EQ(report.boxes, boxes + 1);
    ASSERT_EQ(report.StateOf(plan.outside_box()), FoldState::kFolded);
    EXPECT_EQ(report.places.back().place, kOutsidePlace);
    EXPECT_NEAR(report.places.back().determinant, -1, 1e-12);
  }
}

TEST(TurnedFolds, AFlattenedSumIsNotCertified) {
  const TurnedFolds scene = TwoAround();
  const FoldReport report = ReportOfTurned(scene.plan, StretchedBy(scene, -0.25, -0.75));
  EXPECT_EQ(report.places.size(), report.boxes);
}

TEST(TurnedFolds, NumbersThatOverflowProveNothing) {
  const TurnedFolds scene = TwoAround();
  std::vector<Vec3d> points = scene.plan->identity_points;
  for (Vec3d& p : points) p.x *= 1e308;
  EXPECT_FALSE(ReportOfTurned(scene.plan, points).certified());
}

TEST(TurnedFolds, RecertifyLeadsToTheSameReport) {
  for (const uint32_t mix : {5u, 13u, 21u}) {
    const TurnedFolds scene = DrawTurned(mix, mix == 13);
    const FoldCertifier certifier(scene.plan, FoldScope::kSurface);
    std::vector<Vec3d> points = scene.plan->identity_points;
    const auto own = static_cast<uint32_t>(scene.structures[0].control_point_count());
    FoldReport report = *certifier.Certify(points);
    EXPECT_TRUE(report.certified());
    std::mt19937 random(kTurnedFoldSeed + mix);
    std::uniform_real_distribution<double> uniform(-1.5, 1.5);
    for (int edit = 0; edit < 24; ++edit) {
      SCOPED_TRACE(::testing::Message() << "mix " << mix << ", edit " << edit);
      std::vector<uint32_t> changed;
      for (size_t n = random() % 3 + 1; n-- > 0;) {
        // One third of the edits is of the own lattice, one third of the others, one third of all of them.
        const uint32_t first = edit % 3 == 1 ? own : 0;
        const auto end = edit % 3 == 0 ? own : static_cast<uint32_t>(points.size());
        changed.push_back(first + static_cast<uint32_t>(random()) % (end - first));
        points[changed.back()] += Vec3d{uniform(random), uniform(random), uniform(random)};
      }
      report = certifier.Recertify(report, changed, points);
      ASSERT_EQ(report, *certifier.Certify(points));
    }
    EXPECT_FALSE(report.certified());
  }
}

}  // namespace
}  // namespace latticed
