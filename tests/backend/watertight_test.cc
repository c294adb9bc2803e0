// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// No cracks: both sides of every plan edge, and all patches around a vertex, have the same integers
// and the same floats, at rest and after any edits. The chunks that a watcher gathers after edits
// equal a full evaluation, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/real_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kWatertightSeed = 1974;

struct Scenario {
  std::string_view name;
  PolygonMesh mesh;
  LatticeOptions options;
};

std::vector<Scenario> Scenarios() {
  return {
      {"inside", TorusMesh(7, 5), {.degree = {2, 2, 2}, .extra = {2, 2, 2}}},
      {"partly outside", TorusMesh(7, 5), {.degree = {2, 1, 3}, .scale = 0.7}},
      {"repeated knots",
       TorusMesh(6, 5),
       {.degree = {3, 2, 1}, .extra = {3, 3, 3}, .knots = KnotKind::kRepeated}},
      {"aligned with knot planes",
       CubeMesh(4),
       {.degree = {2, 3, 1}, .extra = {3, 3, 3}, .scale = 1.0}},
      {"aligned, half outside",
       CubeMesh(4),
       {.degree = {1, 2, 1}, .extra = {1, 1, 1}, .scale = 1.0, .shift = {0.5, 0, 0}}},
      {"unconnected", TriangleSoup(40, kWatertightSeed), {.degree = {1, 1, 2}, .extra = {4, 4, 4}}},
  };
}

class Watertight : public BackendTest {
 protected:
  // Edits single control points and small groups. Now and then a point returns to its identity place.
  static std::vector<uint32_t> RandomEdit(const DeformPlan& plan, std::vector<Vec3d>& points,
                                          std::mt19937& random) {
    std::uniform_int_distribution<size_t> any(0, points.size() - 1);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    std::vector<uint32_t> indices;
    const size_t count = 1 + any(random) % 3;
    for (size_t i = 0; i < count; ++i) {
      const size_t index = any(random);
      if (any(random) % 4 == 0) {
        points[index] = plan.identity_points[index];
      } else {
        points[index] += Vec3d{noise(random), noise(random), noise(random)};
      }
      indices.push_back(static_cast<uint32_t>(index));
    }
    return indices;
  }

  // Makes `edits` random edits. Compares the chunks that a watcher was sent with a full evaluation:
  // at rest, after every `compare_every` edits, and after the last.
  void Run(const Scenario& scenario, const ViewSpec& spec, int edits, int compare_every = 1) {
    const LatticeStructure structure =
        MakeStructure(scenario.mesh.ComputeBounds(), scenario.options);
    const Plan plan = MakeTestPlan(scenario.mesh, structure);
    ASSERT_NE(plan, nullptr);
    std::vector<Vec3d> points = IdentityControlPoints(structure);
    QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.5, kWatertightSeed));
    const auto incremental = MakeView(plan, spec);
    const auto full = MakeView(plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(*plan)));
    std::vector<std::vector<uint8_t>> watched = ReadAll(*plan, *incremental);
    std::mt19937 random(kWatertightSeed);
    for (int edit = 0; edit <= edits; ++edit) {
      SCOPED_TRACE(fmt::format("{}, {} segments: edit {}, seed {}", scenario.name, spec.segments,
                               edit, kWatertightSeed));
      if (edit % compare_every == 0 || edit == edits) {
        ASSERT_OK(full->Evaluate(points, box, AllChunks(*plan)));
        const auto expected = ReadAll(*plan, *full);
        ASSERT_TRUE(watched == expected) << "incremental differs from full";
        EXPECT_EQ(CountCracks(*plan, points, spec.segments, Decode(*plan, spec, box, expected)),
                  0u);
        if (HasFailure()) return;
      }
      const std::vector<uint32_t> chunks =
          DirtyByControlPoints(*plan, RandomEdit(*plan, points, random)).chunks;
      ASSERT_OK(incremental->Evaluate(points, box, chunks));
      for (uint32_t chunk : chunks) ASSERT_OK(incremental->Read(chunk, watched[chunk]));
    }
  }

  // Evaluates fewer chunks each round, with other control points, and compares with a full evaluation.
  void EvaluateAnyChunks(const Plan& plan, const ViewSpec& spec) {
    const auto some = MakeView(plan, spec), full = MakeView(plan, spec);
    ASSERT_NE(some, nullptr);
    ASSERT_NE(full, nullptr);
    const std::vector<uint32_t> all = AllChunks(*plan);
    const QuantisationBox box = BoxFor(*plan, Jitter(plan->structure, 0.5, kWatertightSeed));
    ASSERT_OK(some->Evaluate(plan->identity_points, box, all));
    std::mt19937 random(kWatertightSeed);
    for (uint32_t round = 0; round < 6; ++round) {
      SCOPED_TRACE(fmt::format("round {}", round));
      const std::vector<Vec3d> points = Jitter(plan->structure, 0.02, kWatertightSeed + round);
      std::vector<uint32_t> chunks = all;
      std::ranges::shuffle(chunks, random);
      chunks.resize(std::max<size_t>(1, all.size() >> round));
      std::ranges::sort(chunks);
      ASSERT_OK(full->Evaluate(points, box, all));
      const auto expected = ReadAll(*plan, *full);

      ASSERT_OK(some->Evaluate(points, box, chunks));

      std::vector<uint8_t> bytes;
      for (const uint32_t chunk : chunks) {
        bytes.resize(expected[chunk].size());
        ASSERT_OK(some->Read(chunk, bytes));
        ASSERT_TRUE(bytes == expected[chunk]) << "chunk " << chunk;
      }
    }
  }
};

TEST_P(Watertight, QuantisedAfterRandomEdits) {
  for (const Scenario& scenario : Scenarios()) {
    for (const int segments : kFewAndMany) {
      Run(scenario,
          {.segments = segments,
           .normals = NormalMode::kFacet,
           .position_bits = 16,
           .normal_bits = 10},
          20);
    }
  }
}

TEST_P(Watertight, SmoothFloatsAfterRandomEdits) {
  for (const Scenario& scenario : Scenarios()) {
    for (const int segments : kFewAndMany) {
      Run(scenario,
          {.segments = segments, .normals = NormalMode::kSmooth, .format = VertexFormat::kFloat32},
          6);
    }
  }
}

// The largest numbers of segments that CUDA evaluates point by point.
TEST_P(Watertight, MostPointsOneByOneAfterRandomEdits) {
  Run({"six segments", TorusMesh(8, 6), {.degree = {3, 3, 3}, .scale = 0.8}},
      {.segments = 6, .normals = NormalMode::kSmooth, .position_bits = 16}, 6);
  Run({"four segments", TorusMesh(8, 6), {.degree = {2, 2, 2}, .scale = 0.8}},
      {.segments = 4, .format = VertexFormat::kFloat32}, 6);
}

TEST_P(Watertight, ThousandEditsWithoutNormals) {
  const Scenario scenario{"thousand edits", TorusMesh(4, 4), {.scale = 0.8}};
  for (const int segments : kFewAndMany) {
    Run(scenario, {.segments = segments, .normals = NormalMode::kNone, .position_bits = 16}, 1'000,
        2);
  }
}

// The pipelines with products are slower, so they get fewer edits.
TEST_P(Watertight, RealMeshesAfterAThousandEdits) {
  std::vector<RealMesh> meshes = RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  const int edits = GetParam().pipeline == Pipeline::kFused ? 1'000 : 10;
  for (auto& [name, mesh] : meshes) {
    const LatticeOptions options{.extra = {5, 5, 5}, .scale = 0.9};
    Run({name, std::move(mesh), options},
        {.segments = 2, .normals = NormalMode::kNone, .position_bits = 16}, edits, edits / 2);
    if (HasFailure()) return;
  }
}

TEST_P(Watertight, RandomCasesAfterRandomEdits) {
  std::vector<uint32_t> seeds(40);
  std::iota(seeds.begin(), seeds.end(), 1u);
  seeds.push_back(344);  // a vertex shared by patches, none of which is in its owner box
  for (uint32_t seed : seeds) {
    RandomCase one = DrawCase(seed);
    ViewSpec spec{.segments = one.segments,
                  .normals = static_cast<NormalMode>(seed % 3),
                  .format = seed % 4 ? VertexFormat::kQuantised : VertexFormat::kFloat32,
                  .position_bits = 16};
    const std::string name = fmt::format("case {}", seed);
    Run({name, std::move(one.mesh), one.options}, spec, 6);
    if (HasFailure()) return;
  }
}

// Backends may copy to a device, and compose polynomials of, only what the dirty chunks need.
std::vector<Scenario> LargeLattices() {
  return {
      {"inside", TorusMesh(16, 8), {.extra = {14, 15, 14}}},
      {"partly outside",
       TorusMesh(16, 8),
       {.degree = {3, 1, 2}, .extra = {20, 22, 21}, .scale = 0.8}},
      {"repeated knots",
       TorusMesh(10, 6),
       {.degree = {2, 3, 2}, .extra = {16, 15, 16}, .knots = KnotKind::kRepeated}},
  };
}

TEST_P(Watertight, LargeLatticesAfterRandomEdits) {
  const int edits = GetParam().pipeline == Pipeline::kFused ? 60 : 20;
  for (const Scenario& scenario : LargeLattices()) {
    for (const int segments : kFewAndMany) {
      Run(scenario, {.segments = segments, .position_bits = 16}, edits, 6);
      if (HasFailure()) return;
    }
  }
}

// Chunks need not be dirty. A call brings the named chunks to the given control points, whatever
// earlier calls did.
TEST_P(Watertight, AnyChunksOfALargeLatticeComeToTheControlPointsGiven) {
  for (const Scenario& scenario : LargeLattices()) {
    const LatticeStructure structure =
        MakeStructure(scenario.mesh.ComputeBounds(), scenario.options);
    const Plan plan = MakeTestPlan(scenario.mesh, structure);
    ASSERT_NE(plan, nullptr);
    for (const int segments : kFewAndMany) {
      SCOPED_TRACE(
          fmt::format("{}, {} segments, seed {}", scenario.name, segments, kWatertightSeed));
      EvaluateAnyChunks(plan, {.segments = segments, .format = VertexFormat::kFloat32});
      if (HasFailure()) return;
    }
  }
}

// A GPU divides chunks if there are few.
TEST_P(Watertight, FewChunksOfManyHaveTheSameBits) {
  PolygonMesh mesh = TorusMesh(300, 170);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.extra = {5, 5, 5}});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  ASSERT_NE(plan, nullptr);
  const std::vector<uint32_t> all = AllChunks(*plan), few{0, 7, 1'000, all.back()};
  ASSERT_GE(all.size(), 3'000u);
  const ViewSpec spec{.segments = 2, .format = VertexFormat::kFloat32};
  const std::vector<Vec3d> points = Jitter(structure, 0.05, kWatertightSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  const auto read = [&] {
    std::vector<std::vector<uint8_t>> bytes;
    for (const uint32_t chunk : few) {
      bytes.emplace_back(ChunkPoints(*plan, chunk, spec.segments) * BytesPerPoint(spec));
      EXPECT_OK(view->Read(chunk, bytes.back()));
    }
    return bytes;
  };
  ASSERT_OK(view->Evaluate(points, box, all));
  const auto expected = read();
  ASSERT_OK(view->Evaluate(plan->identity_points, box, all));
  EXPECT_NE(read(), expected);

  ASSERT_OK(view->Evaluate(points, box, few));

  EXPECT_EQ(read(), expected) << "seed " << kWatertightSeed;
}

TEST_P(Watertight, AttachedSeamsHoldUntilTheirControlPointsMove) {
  const PolygonMesh mesh = TorusMesh(8, 6);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {2, 2, 2}, .extra = {2, 2, 2}, .scale = 0.7});
  const Plan plan = MakeTestPlan(mesh, structure);
  ASSERT_FALSE(plan->seams.empty());
  std::vector<Vec3d> points = IdentityControlPoints(structure);
  // An inner control point, whose basis functions are zero on every face.
  points[static_cast<size_t>(structure.Index(2, 2, 2))] += Vec3d{0.3, 0, 0};
  for (const bool seam : AttachedSeams(*plan, points)) EXPECT_TRUE(seam);
  for (const int segments : kFewAndMany) {
    const auto evaluated = EvaluateAll(
        plan, points, {.segments = segments, .normals = NormalMode::kNone, .position_bits = 16});

    EXPECT_EQ(CountCracks(*plan, points, segments, evaluated), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Watertight, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
