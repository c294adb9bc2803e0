// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views with a tolerance under lattices that are turned against each other, with and without vertex weights.
#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/tolerance/tolerance_checks.h"
#include "tests/backend/tolerance/tolerance_scenes.h"
#include "tests/backend/turned_scenes.h"

namespace latticed::testing {
namespace {

struct TurnedToleranceScene {
  std::string_view name;
  PolygonMesh mesh;
  std::vector<MovedLattice> lattices;
};

std::vector<TurnedToleranceScene> TurnedToleranceScenes() {
  return {{"both beyond the mesh",
           TorusMesh(14, 10),
           {{{.degree = {2, 1, 3}, .extra = {2, 2, 2}, .scale = 2}},
            {{.degree = {1, 3, 2}, .extra = {1, 2, 1}, .scale = 2, .turn = 0.5}}}},
          {"both end in the mesh",
           CubeMesh(4),
           {{{.extra = {4, 4, 4}, .scale = 0.6}, true},
            {{.extra = {4, 4, 4}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}}, true}}},
          {"three, of the highest degree",
           TorusMesh(7, 5),
           {{{.degree = {3, 3, 3}, .scale = 2}},
            {{.degree = {1, 1, 1}, .scale = 2, .turn = -2}},
            {{.degree = {3, 2, 3}, .shear = 0.2, .scale = 2, .turn = 1}}}},
          {"slivers",
           TriangleSoup(40, kTurnedSeed),
           {{{.degree = {1, 1, 2}, .extra = {2, 2, 2}, .scale = 2}}, {{.scale = 2, .turn = 0.3}}}}};
}

class TurnedTolerance : public BackendTest {
 protected:
  // Calls check for each scene, without weights and with them.
  template <typename Check>
  void ForScenes(const Check& check) {
    for (const bool weighted : {false, true}) {
      for (TurnedToleranceScene& one : TurnedToleranceScenes()) {
        SCOPED_TRACE(
            fmt::format("{}{}, seed {}", one.name, weighted ? ", weighted" : "", kTurnedSeed));
        VertexWeights weights;
        if (weighted) weights = RandomWeights(one.mesh, kTurnedSeed);
        check(MakeMovedPlan(std::move(one.mesh), one.lattices, std::move(weights)));
      }
    }
  }
};

TEST_P(TurnedTolerance, TrianglesAreWithinTheCertificateAndTheTolerance) {
  std::mt19937 random(kTurnedSeed);
  ForScenes([&](const MovedPlan& moved) {
    const DeformPlan& plan = *moved.plan;
    const QuantisationBox box = BoxFor(plan, moved.points);
    for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
      for (const double share : {1e-2, 1e-4}) {
        const ViewSpec spec{
            .segments = 32, .tolerance = share * box.range, .format = format, .position_bits = 16};
        const auto view = MakeView(moved.plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(plan, *view, moved.points, box, whole));

        EXPECT_LE(view->certified_error(), spec.tolerance);
        EXPECT_LE(LargestDistance(plan, moved.points, whole.codes, whole.points, random),
                  view->certified_error());
        EXPECT_EQ(CountCracksBetween(plan, moved.points, whole.codes, whole.points), 0u);
      }
    }
  });
}

TEST_P(TurnedTolerance, PointsAreThoseOfTheDefinition) {
  ForScenes([&](const MovedPlan& moved) {
    const QuantisationBox box = BoxFor(*moved.plan, moved.points);
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
        const ViewSpec spec{.segments = 32,
                            .tolerance = 1e-3 * box.range,
                            .normals = normals,
                            .format = format,
                            .position_bits = 16,
                            .normal_bits = 12};
        const auto view = MakeView(moved.plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(*moved.plan, *view, moved.points, box, whole));
        ExpectPointsOfTheDefinition(*moved.plan, moved.points, spec, box, whole.codes,
                                    whole.points);
      }
    }
  });
}

TEST_P(TurnedTolerance, ChunksAfterAnyEditsAreThoseOfAFullEvaluation) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  std::mt19937 random(kTurnedSeed);
  ForScenes([&](const MovedPlan& moved) {
    const DeformPlan& plan = *moved.plan;
    std::vector<Vec3d> points = moved.points;
    const QuantisationBox box = BoxFor(plan, points);
    const ViewSpec spec{.segments = 32,
                        .tolerance = 1e-3 * box.range,
                        .normals = NormalMode::kSmooth,
                        .position_bits = 16,
                        .normal_bits = 10};
    const auto incremental = MakeView(moved.plan, spec), full = MakeView(moved.plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(plan)));
    Watched watched(plan), expected(plan);
    watched.TakeAll(plan, *incremental);
    for (int edit = 0; edit < 20; ++edit) {
      SCOPED_TRACE(fmt::format("edit {}", edit));
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] += Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> named = DirtyByControlPoints(plan, {{index}}).chunks;
      ASSERT_OK(incremental->Evaluate(points, box, named));
      for (const uint32_t chunk : named) watched.Take(plan, *incremental, chunk);
      for (const uint32_t chunk : incremental->also_changed()) {
        watched.Take(plan, *incremental, chunk);
      }
      ASSERT_OK(full->Evaluate(points, box, AllChunks(plan)));
      expected.TakeAll(plan, *full);
      ASSERT_TRUE(watched == expected);
      ASSERT_EQ(incremental->certified_error(), full->certified_error());
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Backends, TurnedTolerance,
                         ::testing::Values(Subject{"cpu", Pipeline::kGemm},
                                           Subject{"cuda", Pipeline::kGemm}),
                         SubjectName);

}  // namespace
}  // namespace latticed::testing
