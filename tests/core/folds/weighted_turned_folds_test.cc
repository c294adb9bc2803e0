// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds of surfaces with vertex weights under lattices that are turned against each other, against the definition of J on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/folds/fold_certifier.h"
#include "core/folds/turned_determinant.h"
#include "tests/core/folds/turned_fold_fixtures.h"

namespace latticed {
namespace {

constexpr uint32_t kWeighedSumSeed = 71;

using testing::DrawTurned;
using testing::ExpectDeterminantsOfTheDefinition;
using testing::ExpectReportsThatAgreeWithSamples;
using testing::FlatGrid;
using testing::JitterAll;
using testing::LatticeOptions;
using testing::LeastOnPatch;
using testing::PlanTurned;
using testing::ReportOfTurned;
using testing::TorusMesh;
using testing::TurnedFolds;
using testing::Weights;

std::vector<Vec3d> OffsetsFromRest(const DeformPlan& plan, std::span<const Vec3d> points) {
  std::vector<Vec3d> offsets(points.begin(), points.end());
  for (size_t i = 0; i < points.size(); ++i) offsets[i] -= plan.identity_points[i];
  return offsets;
}

VertexWeights SameWeight(const PolygonMesh& mesh, float weight) {
  return std::make_shared<const std::vector<float>>(mesh.positions.size(), weight);
}

// Both contain all of the mesh.
TurnedFolds TwoAround(const PolygonMesh& mesh, VertexWeights weights) {
  return PlanTurned(mesh, std::vector<LatticeOptions>{{.scale = 2.5}, {.scale = 2.5, .turn = 0.7}},
                    std::move(weights));
}

TEST(WeightedTurnedDeterminant, IsTheDefinitionsOnEveryPatch) {
  std::mt19937 random(kWeighedSumSeed);
  for (uint32_t mix = 0; mix < 27; ++mix) {
    SCOPED_TRACE(::testing::Message() << "mix " << mix << ", seed " << kWeighedSumSeed);
    const TurnedFolds scene = DrawTurned(mix, mix % 2 == 0, Weights::kScattered);
    const auto points = JitterAll(scene, 0.4, kWeighedSumSeed + mix);
    const auto offsets = OffsetsFromRest(*scene.plan, points);
    TurnedPatches patches(*scene.plan, points, offsets);
    ASSERT_NO_FATAL_FAILURE(
        ExpectDeterminantsOfTheDefinition(*scene.plan, points, patches, 1e-6, random));
  }
}

// With the same weight everywhere, det J depends on differences of control points alone.
TEST(WeightedTurnedDeterminant, DoesNotDependOnWhereTheLatticesGo) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  for (const float weight : {0.5f, 1.0f}) {
    const TurnedFolds scene = TwoAround(mesh, SameWeight(mesh, weight));
    std::vector<Vec3d> points = JitterAll(scene, 0.2, kWeighedSumSeed);
    for (Vec3d& p : points) {
      for (int a = 0; a < 3; ++a) p[a] = std::round(p[a] * 0x1p20) * 0x1p-20;
    }
    std::vector<Vec3d> moved = points;
    for (Vec3d& p : moved) p += Vec3d{0x1p24, 0x1p24, -0x1p24};
    const auto offsets = OffsetsFromRest(*scene.plan, points);
    const auto moved_offsets = OffsetsFromRest(*scene.plan, moved);
    TurnedPatches near(*scene.plan, points, offsets), far(*scene.plan, moved, moved_offsets);
    BernsteinTriangle here, there;
    for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
      const double slack = near.MakeDeterminant(p, here) + far.MakeDeterminant(p, there);
      ASSERT_LT(slack, 1e-8);
      for (size_t i = 0; i <= here.degree; ++i) {
        for (size_t j = 0; i + j <= here.degree; ++j) {
          ASSERT_NEAR(there.at(i, j), here.at(i, j), slack) << "patch " << p;
        }
      }
    }
  }
}

// The same number with and without weights.
TEST(WeightedTurnedDeterminant, OfWeightOneIsThatWithoutWeights) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const TurnedFolds plain = TwoAround(mesh, nullptr);
  const TurnedFolds weighted = TwoAround(mesh, SameWeight(mesh, 1));
  const auto points = JitterAll(plain, 0.3, kWeighedSumSeed);
  const auto offsets = OffsetsFromRest(*weighted.plan, points);
  TurnedPatches one(*plain.plan, points), other(*weighted.plan, points, offsets);
  BernsteinTriangle want, got;
  ASSERT_EQ(plain.plan->patches.size(), weighted.plan->patches.size());
  for (size_t p = 0; p < plain.plan->patches.size(); ++p) {
    const double slack = one.MakeDeterminant(p, want) + other.MakeDeterminant(p, got);
    EXPECT_EQ(got.degree, want.degree + 3);
    for (const auto& at : {std::array{0.2, 0.3, 0.5}, {1.0, 0.0, 0.0}, {0.0, 0.9, 0.1}}) {
      ASSERT_NEAR(got.Value(at), want.Value(at), slack) << "patch " << p;
    }
  }
}

TEST(WeightedTurnedFolds, ReportsAgreeWithSamplesOfTheDefinition) {
  ExpectReportsThatAgreeWithSamples(Weights::kScattered);
}

// Between moves that are certified and moves that fold lies next to nothing, and what is certified up to there is not folded.
TEST(WeightedTurnedFolds, CertificatesEndWhereFoldsBegin) {
  constexpr int kHalvings = 36;
  for (uint32_t mix = 0; mix < 27; mix += 6) {
    SCOPED_TRACE(::testing::Message() << "mix " << mix << ", seed " << kWeighedSumSeed);
    const TurnedFolds scene = DrawTurned(mix, mix % 2 == 0, Weights::kScattered);
    const std::vector<Vec3d>& rest = scene.plan->identity_points;
    const auto far = JitterAll(scene, 1, kWeighedSumSeed + mix);
    const FoldCertifier certifier(scene.plan, FoldScope::kSurface);
    const auto moved = [&](double share) {
      std::vector<Vec3d> points = rest;
      for (size_t i = 0; i < points.size(); ++i) points[i] += share * (far[i] - rest[i]);
      return points;
    };
    double certified = 0, folded = 1;
    ASSERT_GT(certifier.Certify(moved(folded))->Count(FoldState::kFolded), 0u);
    FoldReport last;
    for (int n = 0; n < kHalvings; ++n) {
      const double middle = 0.5 * (certified + folded);
      const FoldReport report = *certifier.Certify(moved(middle));
      (report.certified() ? certified : folded) = middle;
      if (!report.certified()) last = report;
    }
    EXPECT_GT(certified, 0);
    EXPECT_LT(folded - certified, 1e-9);
    ASSERT_FALSE(last.certified());
    EXPECT_NEAR(last.places.front().determinant, 0, 1e-8);
    const std::vector<Vec3d> points = moved(certified);
    const DirectFfd definition(*scene.plan, points);
    for (size_t p = 0; p < scene.plan->patches.size(); ++p) {
      ASSERT_GT(LeastOnPatch(definition, p, 12), 0) << "patch " << p;
    }
  }
}

// A flat grid on which the weight rises from 0 to 1 along x. What both lattices shift together makes det J = 1 + shift / width.
TEST(WeightedTurnedFolds, ARampFoldsWhereTheSumOfTheShiftsReversesIt) {
  const PolygonMesh mesh = FlatGrid(4, 0);
  const Bounds bounds = mesh.ComputeBounds();
  std::vector<float> weights;
  for (const Vec3d p : mesh.positions) {
    weights.push_back(static_cast<float>((p.x - bounds.min.x) / bounds.extent().x));
  }
  const TurnedFolds scene =
      TwoAround(mesh, std::make_shared<const std::vector<float>>(std::move(weights)));
  const auto shifted = [&](double own, double turned) {
    std::vector<Vec3d> points = scene.plan->identity_points;
    for (size_t i = 0; i < points.size(); ++i) {
      points[i].x += bounds.extent().x * (i < scene.plan->turned[0].first_point ? own : turned);
    }
    return ReportOfTurned(scene.plan, points);
  };

  EXPECT_TRUE(shifted(0, 0).certified());
  EXPECT_TRUE(shifted(-0.6, -0.399).certified());
  EXPECT_TRUE(shifted(-3, 2.5).certified());
  const FoldReport folded = shifted(-0.75, -0.5);

  EXPECT_GT(folded.boxes, 0u);
  EXPECT_EQ(folded.Count(FoldState::kFolded), folded.boxes);
  for (const FoldedBox& box : folded.places) EXPECT_NEAR(box.determinant, -0.25, 1e-6);
}

TEST(WeightedTurnedFolds, WhatRestsDoesNotFold) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const TurnedFolds scene = TwoAround(mesh, SameWeight(mesh, 0));
  std::vector<Vec3d> points = scene.plan->identity_points;
  for (Vec3d& p : points) p.z = -p.z;
  EXPECT_TRUE(ReportOfTurned(scene.plan, points).certified());
}

TEST(WeightedTurnedFolds, NumbersThatOverflowProveNothing) {
  const PolygonMesh mesh = TorusMesh(9, 6);
  const TurnedFolds scene = TwoAround(mesh, SameWeight(mesh, 0.5f));
  std::vector<Vec3d> points = scene.plan->identity_points;
  for (Vec3d& p : points) p.x *= 1e308;
  EXPECT_FALSE(ReportOfTurned(scene.plan, points).certified());
}

TEST(WeightedTurnedFolds, RecertifyLeadsToTheSameReport) {
  for (const uint32_t mix : {5u, 13u}) {
    const TurnedFolds scene = DrawTurned(mix, mix == 13, Weights::kScattered);
    const FoldCertifier certifier(scene.plan, FoldScope::kSurface);
    std::vector<Vec3d> points = scene.plan->identity_points;
    FoldReport report = *certifier.Certify(points);
    EXPECT_TRUE(report.certified());
    std::mt19937 random(kWeighedSumSeed + mix);
    std::uniform_real_distribution<double> uniform(-1.5, 1.5);
    for (int edit = 0; edit < 20; ++edit) {
      SCOPED_TRACE(::testing::Message() << "mix " << mix << ", edit " << edit);
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] += Vec3d{uniform(random), uniform(random), uniform(random)};
      report = certifier.Recertify(report, {{index}}, points);
      ASSERT_EQ(report, *certifier.Certify(points));
    }
    EXPECT_FALSE(report.certified());
  }
}

}  // namespace
}  // namespace latticed
