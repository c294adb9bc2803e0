// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views with a tolerance: triangles within their certificate of the exact surface, no cracks, the same bytes after any
// edits as after a full evaluation, streams that stock decoders read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/edge_levels.h"
#include "core/codec/draco_decode.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/tolerance/tolerance_checks.h"
#include "tests/backend/tolerance/tolerance_scenes.h"
#include "tests/support/holds_integers.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = kToleranceSeed;

class Tolerance : public BackendTest {};

TEST_P(Tolerance, TrianglesAreWithinTheCertificateAndTheTolerance) {
  std::mt19937 random(kSeed);
  for (ToleranceScene& one : ToleranceScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = MakeTestPlan(std::move(one.mesh), structure);
    const std::vector<Vec3d> points = Jitter(structure, 0.1, kSeed);
    const QuantisationBox box = BoxFor(*plan, points);
    for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
      for (const double share : {1e-2, 1e-3, 1e-4}) {
        SCOPED_TRACE(fmt::format("{}, {} of the box, seed {}", one.name, share, kSeed));
        const ViewSpec spec{
            .segments = 32, .tolerance = share * box.range, .format = format, .position_bits = 16};
        const auto view = MakeView(plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(*plan, *view, points, box, whole));
        const double distance = LargestDistance(*plan, points, whole.codes, whole.points, random);

        EXPECT_LE(view->certified_error(), spec.tolerance);
        EXPECT_LE(distance, view->certified_error());
        EXPECT_EQ(CountCracksBetween(*plan, points, whole.codes, whole.points), 0u);
      }
    }
  }
}

TEST_P(Tolerance, PointsOfAllDegreesAreThoseOfTheDefinition) {
  for (int mix = 0; mix < 27; ++mix) {
    PolygonMesh mesh = TorusMesh(6, 5);
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    const LatticeStructure structure =
        MakeStructure(mesh.ComputeBounds(), {.degree = degree, .extra = {1, 2, 1}, .scale = 0.8});
    const Plan plan = MakeTestPlan(std::move(mesh), structure);
    const std::vector<Vec3d> points = Jitter(structure, 0.1, kSeed);
    const QuantisationBox box = BoxFor(*plan, points);
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      for (const int normal_bits : {0, 8, 12}) {  // 0: floats
        SCOPED_TRACE(fmt::format(
            "degree {} {} {}, {} normals, {} bits, seed {}", degree[0], degree[1], degree[2],
            normals == NormalMode::kSmooth ? "smooth" : "facet", normal_bits, kSeed));
        ViewSpec spec{.segments = 32, .tolerance = 1e-3 * box.range, .normals = normals};
        spec.position_bits = 16;
        if (normal_bits == 0) spec.format = VertexFormat::kFloat32;
        if (normal_bits > 0) spec.normal_bits = normal_bits;
        const auto view = MakeView(plan, spec);
        ASSERT_NE(view, nullptr);
        WholeSurface whole;
        ASSERT_NO_FATAL_FAILURE(EvaluateWhole(*plan, *view, points, box, whole));
        ExpectPointsOfTheDefinition(*plan, points, spec, box, whole.codes, whole.points);
      }
    }
  }
}

TEST_P(Tolerance, FewerPointsThanUniformSegmentsAtTheSameError) {
  PolygonMesh mesh = TorusMesh(40, 24);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 2, 2}, .extra = {2, 2, 2}});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const std::vector<Vec3d> points = Jitter(structure, 0.1, kSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  const ViewSpec spec{.tolerance = 1e-4 * box.range,
                      .normals = NormalMode::kNone,
                      .format = VertexFormat::kFloat32};
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  ASSERT_OK(view->Evaluate(points, box, AllChunks(*plan)));
  size_t count = 0;
  for (uint32_t c = 0; c < plan->chunk_count(); ++c) count += ChunkPoints(*view, *plan, c);
  EXPECT_LT(count, plan->patches.size() * 8);  // of 66 at 10 segments
}

TEST_P(Tolerance, CodesThatAreKeptStayAsTheyWere) {
  ToleranceScene scene = std::move(ToleranceScenes().front());
  const LatticeStructure structure = MakeStructure(scene.mesh.ComputeBounds(), scene.options);
  const Plan plan = MakeTestPlan(std::move(scene.mesh), structure);
  const QuantisationBox box = BoxFor(*plan, Jitter(structure, 1.2, kSeed));
  std::vector<PatternCodes> kept;
  std::vector<std::vector<uint16_t>> copies;
  {
    const auto view = MakeView(plan, {.segments = 32, .tolerance = 1e-4 * box.range});
    ASSERT_NE(view, nullptr);
    for (int turn = 0; turn < 5; ++turn) {
      ASSERT_OK(view->Evaluate(Jitter(structure, 0.2 * turn, kSeed), box, AllChunks(*plan)));
      kept.push_back(view->Patterns());
      copies.emplace_back(kept.back().codes.begin(), kept.back().codes.end());
      ASSERT_EQ(copies.back().size(), plan->patches.size());
    }
  }
  for (size_t turn = 0; turn < kept.size(); ++turn) {
    EXPECT_TRUE(std::ranges::equal(kept[turn].codes, copies[turn])) << "turn " << turn;
    EXPECT_TRUE(turn == 0 || copies[turn] != copies[turn - 1]) << "turn " << turn;
  }
  const size_t last = plan->chunk_count() - 1;
  EXPECT_EQ(kept[0].OfChunk(last).size(), plan->patches.size() - 32 * last);
}

TEST_P(Tolerance, ChunksAfterAnyEditsAreThoseOfAFullEvaluationWithoutCracks) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (ToleranceScene& one : ToleranceScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = MakeTestPlan(std::move(one.mesh), structure);
    const QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.8, kSeed));
    const ViewSpec spec{.segments = 32,
                        .tolerance = 1e-4 * box.range,
                        .normals = NormalMode::kSmooth,
                        .position_bits = 16,
                        .normal_bits = 10};
    const auto incremental = MakeView(plan, spec), full = MakeView(plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    std::vector<Vec3d> points = IdentityControlPoints(structure);
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(*plan)));
    Watched watched(*plan), expected(*plan);
    watched.TakeAll(*plan, *incremental);
    std::mt19937 random(kSeed);
    size_t widened = 0;
    for (int edit = 0; edit < 40; ++edit) {
      SCOPED_TRACE(fmt::format("{}: edit {}, seed {}", one.name, edit, kSeed));
      const uint32_t index = static_cast<uint32_t>(random() % points.size());
      points[index] = random() % 4 == 0
                          ? plan->identity_points[index]
                          : points[index] + Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> named = DirtyByControlPoints(*plan, {{index}}).chunks;
      ASSERT_OK(incremental->Evaluate(points, box, named));
      for (const uint32_t chunk : named) watched.Take(*plan, *incremental, chunk);
      for (const uint32_t chunk : incremental->also_changed()) {
        EXPECT_FALSE(std::ranges::binary_search(named, chunk));
        watched.Take(*plan, *incremental, chunk);
        ++widened;
      }
      ASSERT_OK(full->Evaluate(points, box, AllChunks(*plan)));
      expected.TakeAll(*plan, *full);
      ASSERT_TRUE(watched == expected);
      ASSERT_EQ(incremental->certified_error(), full->certified_error());
      ASSERT_EQ(CountCracksBetween(*plan, points, watched.Codes(),
                                   Decode(*plan, spec, box, watched.chunks)),
                0u);
    }
    // A changed level reaches clean neighbours where a mesh is connected.
    if (one.name == "many boxes") {
      EXPECT_GT(widened, 0u);
    }
  }
}

TEST_P(Tolerance, MorePointsThanTheSegmentsWouldGiveDoubleTheTolerance) {
  PolygonMesh mesh = TorusMesh(12, 8);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const std::vector<Vec3d> points = Jitter(structure, 0.2, kSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  const ViewSpec spec{
      .segments = 2, .tolerance = 1e-9 * box.range, .format = VertexFormat::kFloat32};
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  ASSERT_OK(view->Evaluate(points, box, AllChunks(*plan)));
  Watched watched(*plan);
  watched.TakeAll(*plan, *view);
  size_t count = 0;
  for (uint32_t c = 0; c < plan->chunk_count(); ++c) count += ChunkPoints(*view, *plan, c);
  std::mt19937 random(kSeed);
  const double distance = LargestDistance(*plan, points, watched.Codes(),
                                          Decode(*plan, spec, box, watched.chunks), random);

  EXPECT_LE(count, plan->patches.size() * 6);
  EXPECT_GT(count, plan->patches.size() * 3);
  EXPECT_GT(view->certified_error(), spec.tolerance);
  EXPECT_LE(distance, view->certified_error());
}

// Whatever the control points: an evaluation ends, and certifies nothing that it cannot bound.
TEST_P(Tolerance, HugeControlPointsCertifyNothing) {
  PolygonMesh mesh = TorusMesh(7, 5);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  for (const double size : {1e30, 1e200}) {
    std::vector<Vec3d> points = plan->identity_points;
    for (size_t i = 0; i < points.size(); i += 2) points[i].x = size;
    const ViewSpec spec{.tolerance = 1e-3, .format = VertexFormat::kFloat32};
    const auto view = MakeView(plan, spec);
    ASSERT_NE(view, nullptr);
    ASSERT_OK(view->Evaluate(points, BoxFor(*plan, points), AllChunks(*plan)));
    // In double, the matrix pipelines can bound the smaller size.
    const bool overflows = GetParam().pipeline == Pipeline::kFused || size > 1e38;
    EXPECT_EQ(std::isinf(view->certified_error()), overflows) << view->certified_error();
    EXPECT_GT(view->certified_error(), 1e-3 * size);
  }
}

TEST_P(Tolerance, StockDecodersReadChunksOfDifferentSizes) {
  PolygonMesh mesh = TorusMesh(14, 9);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const std::vector<Vec3d> points = Jitter(structure, 0.2, kSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  const ViewSpec spec{.segments = 32, .tolerance = 1e-3 * box.range, .position_bits = 14};
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  const std::vector<uint32_t> all = AllChunks(*plan);
  ASSERT_OK(view->Evaluate(points, box, all));
  Watched watched(*plan);
  watched.TakeAll(*plan, *view);
  for (const Encoding encoding : {Encoding::kDracoPoints, Encoding::kDracoMesh}) {
    const auto streams = view->Encode(all, encoding);
    ASSERT_OK(streams);
    for (const uint32_t chunk : all) {
      const size_t count = ChunkPoints(*view, *plan, chunk);
      EXPECT_TRUE(HoldsIntegers((*streams)[chunk].span(),
                                QuantisedVertices::FromBytes(watched.chunks[chunk], count,
                                                             spec.position_bits, spec.normal_bits)))
          << "chunk " << chunk;
      if (encoding != Encoding::kDracoMesh) continue;
      size_t triangles = 0;
      for (const uint16_t code : watched.patterns[chunk])
        triangles += PatternOf(code).triangles.size();
      const auto decoded = ReadDracoMesh(
          {reinterpret_cast<const char*>((*streams)[chunk].data), (*streams)[chunk].size});
      ASSERT_OK(decoded);
      EXPECT_EQ(decoded->face_count(), triangles);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Tolerance,
                         ::testing::Values(Subject{"cpu", Pipeline::kFused},
                                           Subject{"cpu", Pipeline::kGemm},
                                           Subject{"cuda", Pipeline::kFused},
                                           Subject{"cuda", Pipeline::kGemm}),
                         SubjectName);

}  // namespace
}  // namespace latticed::testing
