// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that are turned against each other: the matrix pipelines of every backend against the definition in double, and
// without cracks. Pipeline fused says that it does not take them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <utility>

#include "core/ffd/box/bernstein.h"
#include "core/ffd/plan/dirty_set.h"
#include "core/ffd/plan/shared_points.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/turned_scenes.h"

namespace latticed::testing {
namespace {

ViewSpec TurnedFloats(int segments, NormalMode normals) {
  return {.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
}

class TurnedLattices : public BackendTest {
 protected:
  void SetUp() override {
    BackendTest::SetUp();
    if (IsSkipped() || HasFatalFailure() || backend_ == nullptr) return;
    if (GetParam().pipeline == Pipeline::kFused) GTEST_SKIP() << "fused does not take them";
  }
  void Check(PolygonMesh mesh, std::span<const MovedLattice> lattices, NormalMode normals,
             VertexWeights weights = nullptr) {
    const MovedPlan moved = MakeMovedPlan(std::move(mesh), lattices, std::move(weights));
    for (const int segments : kFewAndMany) {
      SCOPED_TRACE(fmt::format("{} segments, seed {}", segments, kTurnedSeed));
      ExpectMatchesDefinition(moved.plan, moved.points, TurnedFloats(segments, normals));
    }
  }
  void CheckWeighted(const PolygonMesh& mesh, std::span<const MovedLattice> lattices,
                     NormalMode normals) {
    Check(mesh, lattices, normals, RandomWeights(mesh, kTurnedSeed));
  }
  void CheckAllMixes(bool weighted) {
    for (int mix = 0; mix < 27; ++mix) {
      const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
      SCOPED_TRACE(fmt::format("degree {} {} {}", degree[0], degree[1], degree[2]));
      const std::array<MovedLattice, 2> lattices{
          MovedLattice{{.degree = degree, .scale = 2}},
          MovedLattice{{.degree = {degree[2], degree[0], degree[1]}, .scale = 2, .turn = 0.5}}};
      const bool is_facet = (mix % 2 == 1) != weighted;
      const NormalMode normals = is_facet ? NormalMode::kFacet : NormalMode::kSmooth;
      weighted ? CheckWeighted(TorusMesh(9, 6), lattices, normals)
               : Check(TorusMesh(9, 6), lattices, normals);
    }
  }
};

TEST_P(TurnedLattices, AllDegreeMixesMatchDefinition) { CheckAllMixes(false); }

// The degree of the patches is the turned lattice's, and one lattice ends inside the mesh.
TEST_P(TurnedLattices, ThreeLatticesMatchDefinition) {
  const std::array<MovedLattice, 3> lattices{
      MovedLattice{{.degree = {1, 1, 1}, .scale = 2}},
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}}, true},
      MovedLattice{{.degree = {3, 2, 3}, .shear = 0.2, .scale = 2, .turn = -2}}};
  Check(TorusMesh(12, 9), lattices, NormalMode::kFacet);
  Check(TorusMesh(12, 9), lattices, NormalMode::kSmooth);
}

TEST_P(TurnedLattices, OutsideTheFirstLatticeTheOthersMoveTheSurface) {
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
                                             MovedLattice{{.scale = 2, .turn = 0.8}}};
  const MovedPlan moved = MakeMovedPlan(TorusMesh(12, 9), lattices);
  ASSERT_GT(moved.plan->outside_patches, 0u);
  ASSERT_GT(moved.plan->seams.size(), 0u);
  for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
    ExpectMatchesDefinition(moved.plan, moved.points, TurnedFloats(5, normals));
  }
}

TEST_P(TurnedLattices, SurfacesAreWatertight) {
  const std::array<MovedLattice, 3> lattices{
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}}, true},
      MovedLattice{{.scale = 2, .turn = -2}}};
  for (const ViewSpec& spec : {TurnedFloats(4, NormalMode::kNone), ViewSpec{.segments = 7}}) {
    for (PolygonMesh mesh : {TorusMesh(12, 9), CubeMesh(4)}) {
      const MovedPlan moved = MakeMovedPlan(std::move(mesh), lattices);
      const std::vector<ViewPoint> points = EvaluateAll(moved.plan, moved.points, spec);
      EXPECT_EQ(CountCracks(*moved.plan, moved.points, spec.segments, points), 0u);
    }
  }
}

TEST_P(TurnedLattices, ControlNetsMatchDefinition) {
  const std::array<MovedLattice, 2> lattices{
      MovedLattice{{.degree = {1, 2, 1}, .scale = 2}},
      MovedLattice{{.degree = {2, 2, 2}, .scale = 2, .turn = 0.5}}};
  const PolygonMesh mesh = TorusMesh(9, 6);
  for (const VertexWeights& weights : {VertexWeights(), RandomWeights(mesh, kTurnedSeed)}) {
    SCOPED_TRACE(weights == nullptr ? "no weights" : "weights");
    const MovedPlan moved = MakeMovedPlan(mesh, lattices, weights);
    auto target = backend_->Prepare(moved.plan, GetParam().pipeline);
    ASSERT_OK(target);
    auto nets = (*target)->ControlNets(moved.points, 0, moved.plan->patches.size());
    ASSERT_OK(nets);
    const int n = weights == nullptr ? 6 : 7;
    const auto m = static_cast<size_t>(BernsteinCount(n));
    ASSERT_EQ(nets->size(), moved.plan->patches.size() * m * 3);
    const DirectFfd direct(*moved.plan, moved.points);
    for (size_t p = 0; p < moved.plan->patches.size(); ++p) {
      for (const auto& b : {std::array{0.0, 1.0, 0.0}, {0.2, 0.3, 0.5}, {0.6, 0.1, 0.3}}) {
        const Vec3d expected = direct.EvaluatePosition(p, b).position;
        ASSERT_LE(Norm(PointOfNet(nets->data() + p * 3 * m, n, b) - expected), 1e-12)
            << "patch " << p;
      }
    }
  }
}

TEST_P(TurnedLattices, AllDegreeMixesWithWeightsMatchDefinition) { CheckAllMixes(true); }

// Patches outside the first lattice take weights of what the second one moves.
TEST_P(TurnedLattices, WeightsCountWhereverALatticeMoves) {
  const std::array<MovedLattice, 3> lattices{
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.5, .turn = 1, .shift = {0.4, 0, 0}}, true},
      MovedLattice{{.scale = 2, .turn = -2}}};
  for (const PolygonMesh& mesh :
       {TorusMesh(12, 9), TorusMesh(9, 6, {1500, -2000, 1200}), CubeMesh(4)}) {
    const VertexWeights weights = RandomWeights(mesh, kTurnedSeed);
    const MovedPlan moved = MakeMovedPlan(mesh, lattices, weights);
    ASSERT_GT(moved.plan->outside_patches, 0u);
    for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
      CheckWeighted(mesh, lattices, normals);
    }
    for (const ViewSpec& spec : {TurnedFloats(4, NormalMode::kNone), ViewSpec{.segments = 7}}) {
      const std::vector<ViewPoint> points = EvaluateAll(moved.plan, moved.points, spec);
      EXPECT_EQ(CountCracks(*moved.plan, moved.points, spec.segments, points), 0u);
    }
  }
}

// With a detached seam and one that rests: both sides take the outside's point where the weight is 0.
TEST_P(TurnedLattices, SeamsOfWeightedMeshesAreWhole) {
  const PolygonMesh mesh = TorusMesh(9, 6, {1500, -2000, 1200});  // where float32 rounds much
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.extra = {2, 2, 2}, .scale = 0.7}},
                                             MovedLattice{{.scale = 2, .turn = 0.8}}};
  std::vector<float> numbers;
  const double middle = mesh.ComputeBounds().center().x;
  for (const Vec3d p : mesh.positions) numbers.push_back(p.x < middle ? 0 : 0.5f);
  const auto weights = std::make_shared<const std::vector<float>>(std::move(numbers));
  const MovedPlan moved = MakeMovedPlan(mesh, lattices, weights);
  const std::vector<bool> attached = AttachedSeams(*moved.plan, moved.points);
  const auto resting = static_cast<size_t>(std::ranges::count(attached, true));
  EXPECT_GT(resting, 10u);
  EXPECT_GT(attached.size() - resting, 10u);
  for (const NormalMode normals : {NormalMode::kNone, NormalMode::kSmooth}) {
    const ViewSpec spec = TurnedFloats(4, normals);
    const auto points = EvaluateAll(moved.plan, moved.points, spec);
    EXPECT_EQ(CountCracks(*moved.plan, moved.points, spec.segments, points), 0u);
    ExpectMatchesDefinition(moved.plan, moved.points, spec);
  }
}

// An edge on a knot plane between two triangles of the upper box: no patch of the lower box, which owns it, has its points.
TEST_P(TurnedLattices, EdgesThatNoPatchOwnsTakeWeights) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0},     {0, 1, 0},      {1, 0.4, -1},     {1, 0.6, 1},
                    {-1, 0.2, -1}, {-1, 0.9, 0.3}, {-0.5, 0.5, -0.6}};
  mesh.corner_vertices = {0, 1, 2, 1, 0, 3, 4, 5, 6};
  mesh.face_offsets = {0, 3, 6, 9};
  const auto weights = std::make_shared<const std::vector<float>>(
      std::vector<float>{0.3f, 0.8f, 1, 0.1f, 0.5f, 0, 1});
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.extra = {1, 0, 0}, .scale = 2}},
                                             MovedLattice{{.scale = 2, .turn = 0.8}}};
  for (const size_t count : {1u, 2u}) {
    SCOPED_TRACE(fmt::format("{} lattices, seed {}", count, kTurnedSeed));
    const MovedPlan moved = MakeMovedPlan(mesh, std::span(lattices).first(count), weights);
    ASSERT_GT(SharedPoints(*moved.plan).orphans().size(), 0u);
    const ViewSpec spec = TurnedFloats(5, NormalMode::kFacet);
    const auto points = EvaluateAll(moved.plan, moved.points, spec);
    EXPECT_EQ(CountCracks(*moved.plan, moved.points, spec.segments, points), 0u);
    ExpectMatchesDefinition(moved.plan, moved.points, spec);
  }
}

TEST_P(TurnedLattices, WeightZeroRestsAndWeightOneFollows) {
  const std::array<MovedLattice, 2> lattices{
      MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
      MovedLattice{{.degree = {1, 3, 2}, .scale = 2, .turn = 0.8}}};
  const PolygonMesh mesh = TorusMesh(9, 6);
  const auto constant = [&](float w) {
    return std::make_shared<const std::vector<float>>(mesh.positions.size(), w);
  };
  const MovedPlan resting = MakeMovedPlan(mesh, lattices, constant(0)),
                  following = MakeMovedPlan(mesh, lattices, constant(1)),
                  plain = MakeMovedPlan(mesh, lattices);
  std::vector<uint32_t> patches(plain.plan->patches.size());
  std::iota(patches.begin(), patches.end(), 0u);
  for (const int segments : kFewAndMany) {
    const ViewSpec spec = TurnedFloats(segments, NormalMode::kSmooth);
    const auto zero = EvaluateAll(resting.plan, resting.points, spec);
    const auto at_rest = EvaluateAll(resting.plan, resting.plan->identity_points, spec);
    const auto one = EvaluateAll(following.plan, following.points, spec);

    ASSERT_EQ(zero.size(), one.size());
    double most = 0;
    for (size_t i = 0; i < zero.size(); ++i) {
      ASSERT_EQ(zero[i].position, at_rest[i].position) << "point " << i;
      most = std::max(most, Norm(one[i].position - zero[i].position));
    }
    const Definition unweighted(*plain.plan, plain.points, segments, spec.normals, patches);
    EXPECT_OK(unweighted.Check(GetParam().pipeline, one));
    EXPECT_GT(most, 0.01);
  }
}

// Vertices of weight 0 among others: their points are those at rest, whatever is around them.
TEST_P(TurnedLattices, VerticesOfWeightZeroRest) {
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
                                             MovedLattice{{.scale = 2, .turn = 0.8}}};
  const PolygonMesh mesh = TorusMesh(9, 6);
  const MovedPlan moved = MakeMovedPlan(mesh, lattices, RandomWeights(mesh, kTurnedSeed));
  const DeformPlan& plan = *moved.plan;
  const int segments = 4;
  const auto points =
      EvaluateAll(moved.plan, moved.points, TurnedFloats(segments, NormalMode::kNone));
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  size_t count = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = plan.patches[p].vertex[c];
      if (plan.vertex_weights[v] != 0) continue;
      ++count;
      const Vec3d at = points[p * pattern.points.size() + pattern.edge_points[c][0]].position;
      const double most = 0x1p-24 * plan.mesh_bounds.diagonal();
      ASSERT_LE(Norm(at - plan.vertices[v].world), most) << "patch " << p;
    }
  }
  EXPECT_GT(count, 100u);
}

TEST_P(TurnedLattices, ChunksAfterAnyEditsAreThoseOfAFullEvaluation) {
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.extra = {4, 4, 4}, .scale = 0.6}, true},
                                             MovedLattice{{.extra = {2, 2, 2}, .turn = 0.8}}};
  const PolygonMesh mesh = TorusMesh(14, 10);
  for (const VertexWeights& weights : {VertexWeights(), RandomWeights(mesh, kTurnedSeed)}) {
    const MovedPlan moved = MakeMovedPlan(mesh, lattices, weights);
    const DeformPlan& plan = *moved.plan;
    std::vector<Vec3d> points = moved.points;
    const QuantisationBox box = BoxFor(plan, points);
    const ViewSpec spec{.segments = 5, .normals = NormalMode::kSmooth, .position_bits = 16};
    const auto incremental = MakeView(moved.plan, spec), full = MakeView(moved.plan, spec);
    ASSERT_NE(incremental, nullptr);
    ASSERT_NE(full, nullptr);
    using Bytes = std::vector<uint8_t>;
    const auto read = [&](DeformView& view, uint32_t chunk) {
      Bytes bytes(ChunkPoints(plan, chunk, spec.segments) * BytesPerPoint(spec));
      EXPECT_OK(view.Read(chunk, bytes));
      return bytes;
    };
    ASSERT_OK(incremental->Evaluate(points, box, AllChunks(plan)));
    std::vector<Bytes> had;  // by somebody who reads what is named
    for (const uint32_t chunk : AllChunks(plan)) had.push_back(read(*incremental, chunk));
    std::mt19937 random(kTurnedSeed);
    std::uniform_real_distribution<double> noise(-0.1, 0.1);
    size_t left = 0;
    for (int edit = 0; edit < 30; ++edit) {
      SCOPED_TRACE(fmt::format("edit {}, seed {}", edit, kTurnedSeed));
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] += Vec3d{noise(random), noise(random), noise(random)};
      const std::vector<uint32_t> named = DirtyByControlPoints(plan, {{index}}).chunks;
      left += plan.chunk_count() - named.size();
      ASSERT_OK(incremental->Evaluate(points, box, named));
      ASSERT_OK(full->Evaluate(points, box, AllChunks(plan)));
      for (const uint32_t chunk : named) had[chunk] = read(*incremental, chunk);
      for (const uint32_t chunk : AllChunks(plan)) {
        ASSERT_EQ(had[chunk], read(*full, chunk)) << "chunk " << chunk;
      }
    }
    EXPECT_GT(left, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, TurnedLattices, ::testing::ValuesIn(Subjects()), SubjectName);

class TurnedRefusals : public BackendTest {};

TEST_P(TurnedRefusals, PipelinesThatDoNotTakeThemSaySo) {
  const std::array<MovedLattice, 2> lattices{MovedLattice{{.scale = 2}},
                                             MovedLattice{{.scale = 2, .turn = 0.5}}};
  const MovedPlan moved = MakeMovedPlan(TorusMesh(9, 6), lattices);
  auto target = backend_->Prepare(moved.plan, GetParam().pipeline);
  if (GetParam().pipeline == Pipeline::kFused) {
    EXPECT_THAT(target, StatusIs(absl::StatusCode::kFailedPrecondition));
  } else {
    ASSERT_OK(target);
    EXPECT_FALSE((*target)->has_edge_bounds());
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, TurnedRefusals, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
