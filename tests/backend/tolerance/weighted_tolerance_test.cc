// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views with a tolerance of meshes with vertex weights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/adaptive/adaptive_reference.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/tolerance/tolerance_checks.h"
#include "tests/backend/tolerance/tolerance_scenes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kWeightedToleranceSeed = 64;

// About a third of the weights are 0 and a third are 1.
Plan ScatteredPlan(PolygonMesh mesh, const LatticeStructure& structure) {
  std::mt19937 random(kWeightedToleranceSeed);
  std::uniform_real_distribution<float> uniform(-1, 2);
  std::vector<float> weights(mesh.positions.size());
  for (float& w : weights) w = std::clamp(uniform(random), 0.0f, 1.0f);
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structure, {},
                       NeverStop, std::make_shared<const std::vector<float>>(std::move(weights)));
  EXPECT_OK(plan);
  return plan.ok() ? *plan : nullptr;
}

class WeightedTolerance : public BackendTest {};

TEST_P(WeightedTolerance, TrianglesAreWithinTheCertificateAndTheTolerance) {
  std::mt19937 random(kWeightedToleranceSeed);
  for (ToleranceScene& one : ToleranceScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = ScatteredPlan(std::move(one.mesh), structure);
    const std::vector<Vec3d> points = Jitter(structure, 0.1, kWeightedToleranceSeed);
    const QuantisationBox box = BoxFor(*plan, points);
    for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
      for (const double share : {1e-2, 1e-3, 1e-4}) {
        SCOPED_TRACE(
            fmt::format("{}, {} of the box, seed {}", one.name, share, kWeightedToleranceSeed));
        const ViewSpec spec{
            .segments = 32, .tolerance = share * box.range, .format = format, .position_bits = 16};
        const auto view = MakeView(plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(*plan, *view, points, box, whole));

        const double distance = LargestDistance(*plan, points, whole.codes, whole.points, random);

        EXPECT_LE(view->certified_error(), spec.tolerance);
        EXPECT_LE(distance, view->certified_error());
        EXPECT_GT(distance, 0);
        EXPECT_EQ(CountCracksBetween(*plan, points, whole.codes, whole.points), 0u);
      }
    }
  }
}

TEST_P(WeightedTolerance, PointsOfAllDegreesAreThoseOfTheDefinition) {
  for (int mix = 0; mix < 27; ++mix) {
    PolygonMesh mesh = TorusMesh(6, 5);
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    const LatticeStructure structure =
        MakeStructure(mesh.ComputeBounds(), {.degree = degree, .extra = {1, 2, 1}, .scale = 0.8});
    const Plan plan = ScatteredPlan(std::move(mesh), structure);
    const std::vector<Vec3d> points = Jitter(structure, 0.1, kWeightedToleranceSeed);
    const QuantisationBox box = BoxFor(*plan, points);
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
        SCOPED_TRACE(fmt::format("degree {} {} {}, normals {}, seed {}", degree[0], degree[1],
                                 degree[2], static_cast<int>(normals), kWeightedToleranceSeed));
        const ViewSpec spec{.segments = 32,
                            .tolerance = 1e-3 * box.range,
                            .normals = normals,
                            .format = format,
                            .position_bits = 16,
                            .normal_bits = 12};
        const auto view = MakeView(plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(*plan, *view, points, box, whole));
        ExpectPointsOfTheDefinition(*plan, points, spec, box, whole.codes, whole.points);
      }
    }
  }
}

TEST_P(WeightedTolerance, ChunksAfterAnyEditsAreThoseOfAFullEvaluationWithoutCracks) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (ToleranceScene& one : ToleranceScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = ScatteredPlan(std::move(one.mesh), structure);
    const QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.8, kWeightedToleranceSeed));
    const ViewSpec spec{.segments = 32,
                        .tolerance = 1e-4 * box.range,
                        .normals = NormalMode::kSmooth,
                        .position_bits = 16,
                        .normal_bits = 10};
    const auto incremental = MakeView(plan, spec), full = MakeView(plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    std::vector<Vec3d> points = plan->identity_points;
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(*plan)));
    Watched watched(*plan), expected(*plan);
    watched.TakeAll(*plan, *incremental);
    std::mt19937 random(kWeightedToleranceSeed);
    for (int edit = 0; edit < 12; ++edit) {
      SCOPED_TRACE(fmt::format("{}: edit {}, seed {}", one.name, edit, kWeightedToleranceSeed));
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] += Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> named = DirtyByControlPoints(*plan, {{index}}).chunks;
      ASSERT_OK(incremental->Evaluate(points, box, named));
      for (const uint32_t chunk : named) watched.Take(*plan, *incremental, chunk);
      for (const uint32_t chunk : incremental->also_changed()) {
        watched.Take(*plan, *incremental, chunk);
      }
      ASSERT_OK(full->Evaluate(points, box, AllChunks(*plan)));
      expected.TakeAll(*plan, *full);
      ASSERT_TRUE(watched == expected);
      ASSERT_EQ(incremental->certified_error(), full->certified_error());
      ASSERT_EQ(CountCracksBetween(*plan, points, watched.Codes(),
                                   Decode(*plan, spec, box, watched.chunks)),
                0u);
    }
  }
}

// A plane patch of which one corner rests is curved, though the lattice only moves: w is linear, and so is F - x.
TEST_P(WeightedTolerance, WhatRestsAndWhatOnlyMovesTakesNoPoints) {
  const PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const auto constant = [&](float weight) {
    return *MakePlan(std::make_shared<const PolygonMesh>(mesh), structure, {}, NeverStop,
                     std::make_shared<const std::vector<float>>(mesh.positions.size(), weight));
  };
  const Plan rests = constant(0), some = ScatteredPlan(mesh, structure);
  std::vector<Vec3d> shifted = rests->identity_points;
  for (Vec3d& p : shifted) p += Vec3d{0.5, 0, 0};
  const auto points_of = [&](const Plan& plan, const std::vector<Vec3d>& points) -> size_t {
    const QuantisationBox box = BoxFor(*plan, points);
    const auto view = MakeView(
        plan, {.segments = 32, .tolerance = 1e-4 * box.range, .format = VertexFormat::kFloat32});
    if (view == nullptr) return 0;  // MakeView has failed the test
    EXPECT_OK(view->Evaluate(points, box, AllChunks(*plan)));
    size_t count = 0;
    for (uint32_t c = 0; c < plan->chunk_count(); ++c) count += ChunkPoints(*view, *plan, c);
    return count;
  };

  const size_t at_rest = points_of(rests, Jitter(structure, 0.2, kWeightedToleranceSeed));

  EXPECT_EQ(at_rest, 3 * rests->patches.size());
  // x + w d is linear on each triangle.
  EXPECT_EQ(points_of(some, shifted), 3 * some->patches.size());
  EXPECT_GT(points_of(some, Jitter(structure, 0.2, kWeightedToleranceSeed)),
            6 * some->patches.size());
}

TEST_P(WeightedTolerance, HugeControlPointsCertifyNothing) {
  PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = ScatteredPlan(std::move(mesh), structure);
  for (const double size : {1e30, 1e200}) {
    std::vector<Vec3d> points = plan->identity_points;
    for (size_t i = 0; i < points.size(); i += 2) points[i].x = size;
    const auto view = MakeView(plan, {.tolerance = 1e-3, .format = VertexFormat::kFloat32});
    ASSERT_NE(view, nullptr);
    ASSERT_OK(view->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
    EXPECT_GE(view->certified_error(), 1e-7 * size) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, WeightedTolerance,
                         ::testing::Values(Subject{"cpu", Pipeline::kFused},
                                           Subject{"cpu", Pipeline::kGemm},
                                           Subject{"cpu-spanned", Pipeline::kFused},
                                           Subject{"cuda", Pipeline::kFused},
                                           Subject{"cuda", Pipeline::kGemm}),
                         SubjectName);

// Bounds in float32 are not below those of the reference, which is exact but for rounding in double.
TEST(WeightedReference, TellsTheSecondDerivativesOfTheDefinition) {
  const PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 3, 1}, .extra = {1, 1, 1}});
  const Plan plan = ScatteredPlan(mesh, structure);
  const std::vector<Vec3d> points = Jitter(structure, 0.1, kWeightedToleranceSeed);
  const DirectFfd definition(*plan, points);
  const auto bounds = AdaptiveReference(plan).Bounds(points);
  std::mt19937 random(kWeightedToleranceSeed);
  std::uniform_real_distribution<double> uniform(0.05, 1);
  double largest_share = 0;
  for (size_t p = 0; p < plan->patches.size(); ++p) {
    const double a = uniform(random), b = uniform(random), c = uniform(random), sum = a + b + c;
    const std::array<double, 3> at{a / sum, b / sum, c / sum};
    for (size_t e = 0; e < 3; ++e) {
      constexpr double kStep = 0.01;
      const auto moved = [&](double h) {
        std::array<double, 3> to = at;
        to[e] -= h;
        to[(e + 1) % 3] += h;
        return definition.EvaluatePosition(p, to).position;
      };
      const Vec3d second = (moved(kStep) - 2 * moved(0) + moved(-kStep)) / (kStep * kStep);
      ASSERT_LE(Norm(second), bounds[p].edge[e] * (1 + 1e-6) + 1e-9) << "patch " << p;
      if (bounds[p].edge[e] > 1e-3) {
        largest_share = std::max(largest_share, Norm(second) / bounds[p].edge[e]);
      }
    }
  }
  EXPECT_GT(largest_share, 0.8) << "the bounds are loose";
}

}  // namespace
}  // namespace latticed::testing
