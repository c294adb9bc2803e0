// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices that are turned against each other: the matrix pipelines of every backend against the definition in double, and
// without cracks. Pipeline fused says that it does not take them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include "fmt/format.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kTurnedSeed = 20261201;
constexpr double kTurnedNoise = 0.08;

// A plan and its control points, which are moved. Those of a lattice with `rests` at its faces are moved inside alone, so that
// the surface is whole where the lattice ends.
struct MovedPlan {
  Plan plan;
  std::vector<Vec3d> points;
};

struct MovedLattice {
  LatticeOptions options;
  bool rests = false;
};

void RestAtFaces(const LatticeStructure& s, std::span<const Vec3d> at_rest,
                 std::vector<Vec3d>& points) {
  for (int k = 0; k < s.size[2]; ++k) {
    for (int j = 0; j < s.size[1]; ++j) {
      for (int i = 0; i < s.size[0]; ++i) {
        const std::array<int, 3> place{i, j, k};
        bool inner = true;
        for (size_t a = 0; a < 3; ++a) {
          inner = inner && place[a] >= s.degree[a] && place[a] < s.size[a] - s.degree[a];
        }
        const auto index = static_cast<size_t>(s.Index(i, j, k));
        if (!inner) points[index] = at_rest[index];
      }
    }
  }
}

MovedPlan MakeMovedPlan(PolygonMesh mesh, std::span<const MovedLattice> lattices) {
  MovedPlan result;
  std::vector<LatticeStructure> structures;
  for (const auto& [options, rests] : lattices) {
    structures.push_back(MakeStructure(mesh.ComputeBounds(), options));
    const auto seed = kTurnedSeed + static_cast<uint32_t>(structures.size());
    std::vector<Vec3d> points = Jitter(structures.back(), kTurnedNoise, seed);
    if (rests) RestAtFaces(structures.back(), IdentityControlPoints(structures.back()), points);
    result.points.insert(result.points.end(), points.begin(), points.end());
  }
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(mesh)), structures[0], {},
                       NeverStop, nullptr, std::span(structures).subspan(1));
  EXPECT_OK(plan);
  if (plan.ok()) result.plan = *plan;
  return result;
}

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
  void Check(PolygonMesh mesh, std::span<const MovedLattice> lattices, NormalMode normals) {
    const MovedPlan moved = MakeMovedPlan(std::move(mesh), lattices);
    for (const int segments : kFewAndMany) {
      SCOPED_TRACE(fmt::format("{} segments, seed {}", segments, kTurnedSeed));
      ExpectMatchesDefinition(moved.plan, moved.points, TurnedFloats(segments, normals));
    }
  }
};

TEST_P(TurnedLattices, AllDegreeMixesMatchDefinition) {
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    SCOPED_TRACE(fmt::format("degree {} {} {}", degree[0], degree[1], degree[2]));
    const std::array<MovedLattice, 2> lattices{
        MovedLattice{{.degree = degree, .scale = 2}},
        MovedLattice{{.degree = {degree[2], degree[0], degree[1]}, .scale = 2, .turn = 0.5}}};
    Check(TorusMesh(9, 6), lattices, mix % 2 ? NormalMode::kFacet : NormalMode::kSmooth);
  }
}

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
  const MovedPlan moved = MakeMovedPlan(TorusMesh(9, 6), lattices);
  auto target = backend_->Prepare(moved.plan, GetParam().pipeline);
  ASSERT_OK(target);
  auto nets = (*target)->ControlNets(moved.points, 0, moved.plan->patches.size());
  ASSERT_OK(nets);
  const size_t m = 28;  // of degree 6
  ASSERT_EQ(nets->size(), moved.plan->patches.size() * m * 3);
  const DirectFfd direct(*moved.plan, moved.points);
  for (size_t p = 0; p < moved.plan->patches.size(); ++p) {
    const double* net = &(*nets)[3 * m * p];
    // The corners of a net are on the surface: numbers 0, m - 7 and m - 1.
    const std::array<size_t, 3> places{0, m - 7, m - 1};
    for (size_t c = 0; c < 3; ++c) {
      std::array<double, 3> b{};
      b[c] = 1;
      const double* at = net + 3 * places[c];
      const Vec3d expected = direct.EvaluatePosition(p, b).position;
      ASSERT_LE(Norm(Vec3d{at[0], at[1], at[2]} - expected), 1e-10) << "patch " << p;
    }
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
  auto mesh = moved.plan->mesh;
  const VertexWeights weights =
      std::make_shared<const std::vector<float>>(mesh->positions.size(), 0.5f);
  const std::array turned{moved.plan->turned[0].structure};
  auto weighted = MakePlan(mesh, moved.plan->structure, {}, NeverStop, weights, turned);
  ASSERT_OK(weighted);
  EXPECT_THAT(backend_->Prepare(*weighted, GetParam().pipeline),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

INSTANTIATE_TEST_SUITE_P(Backends, TurnedRefusals, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
