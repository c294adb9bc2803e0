// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Exported surfaces compared with the definition in double, their UVs and groups, control nets, and
// exports that are cancelled.
#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "core/cpu/cpu_backend.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/mesh/triangulated.h"
#include "server/engine/exports/control_nets.h"
#include "server/engine/exports/exact_surface.h"
#include "server/engine/exports/original_mesh.h"
#include "server/engine/exports/welded_points.h"
#include "tests/server/scenes/export_input.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

// A flat grid. The UVs of a vertex are its x and y. A face's x decides which of two groups it is in.
std::shared_ptr<const PolygonMesh> TexturedGrid() {
  auto mesh = std::make_shared<PolygonMesh>(testing::FlatGrid(4, 0.5));
  for (const Vec3d p : mesh->positions) {
    mesh->uvs.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
  }
  mesh->corner_uvs = mesh->corner_vertices;
  mesh->group_names = {"left", "right"};
  for (size_t f = 0; f < mesh->face_count(); ++f) {
    double x = 0;
    for (uint32_t c = mesh->face_offsets[f]; c < mesh->face_offsets[f + 1]; ++c) {
      x += mesh->positions[mesh->corner_vertices[c]].x / 4;
    }
    mesh->face_groups.push_back(x < 0.5 ? 0 : 1);
  }
  return mesh;
}

class ExportTest : public ::testing::Test {
 protected:
  void SetUp() override { Make(TexturedGrid(), 0); }

  void Make(std::shared_ptr<const PolygonMesh> mesh, double jitter) {
    auto input = testing::MakeExportInput(render_backend_, std::move(mesh), {2, 3, 1}, jitter);
    ASSERT_OK(input);
    input_ = *std::move(input);
  }

  std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 1});
  RenderBackend render_backend_{backend_.get(), std::make_shared<MemoryBudget>(uint64_t{1} << 30)};
  RenderInput input_;
};

// The definition of a corner of the tessellation with `segments`.
DirectFfd::SurfacePoint Definition(const RenderInput& input, size_t corner, int segments,
                                   DirectFfd::Normal normal) {
  const auto& pattern = TessellationPattern::Get(segments);
  const size_t per_patch = 3 * pattern.triangles.size();
  const size_t patch = corner / per_patch, in_patch = corner % per_patch;
  const auto& p = pattern.points[pattern.triangles[in_patch / 3][in_patch % 3]];
  const double s = segments;
  return DirectFfd(*input.state->plan, *input.state->control_points)
      .Evaluate(patch, {p[0] / s, p[1] / s, p[2] / s}, normal);
}

// How many triangles have an edge, by its vertices.
std::map<std::pair<uint32_t, uint32_t>, int> EdgeUses(const PolygonMesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const uint32_t first = mesh.face_offsets[f], count = mesh.face_offsets[f + 1] - first;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t a = mesh.corner_vertices[first + i];
      const uint32_t b = mesh.corner_vertices[first + (i + 1) % count];
      ++uses[std::minmax(a, b)];
    }
  }
  return uses;
}

TEST_F(ExportTest, CornersMatchTheDefinition) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8, {100, 0, -50})), 0.2);
  for (const int segments : {1, 2, 3, 6}) {
    const auto mesh =
        ExactSurface(input_, {.segments = segments, .normals = NormalMode::kFacet}, NeverStop);
    ASSERT_OK(mesh);
    ASSERT_OK(Validate(*mesh));
    ASSERT_EQ(mesh->corner_count(),
              input_.state->plan->patches.size() * 3 * size_t(segments * segments));
    const double diagonal = mesh->ComputeBounds().diagonal();
    for (size_t c = 0; c < mesh->corner_count(); ++c) {
      const auto wanted = Definition(input_, c, segments, DirectFfd::Normal::kFacet);
      ASSERT_LE(Norm(mesh->positions[mesh->corner_vertices[c]] - wanted.position), 1e-6 * diagonal);
      const Vec3d normal = ToDouble(mesh->normals[mesh->corner_normals[c]]);
      ASSERT_NEAR(Norm(normal), 1, 1e-6);
      if (wanted.kappa > 100) continue;
      ASSERT_LE(Norm(normal - wanted.normal), 4e-3) << c;
    }
  }
}

// Each edge of a closed surface belongs to two triangles only if patches share their vertices.
TEST_F(ExportTest, ATorusIsOneClosedSurface) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8)), 0.2);
  for (const int segments : {1, 2, 5}) {
    const auto mesh =
        ExactSurface(input_, {.segments = segments, .normals = NormalMode::kNone}, NeverStop);
    ASSERT_OK(mesh);
    const auto edges = EdgeUses(*mesh);
    for (const auto& [edge, uses] : edges) ASSERT_EQ(uses, 2) << edge.first << ' ' << edge.second;
    EXPECT_EQ(mesh->positions.size() + mesh->face_count(), edges.size());  // Euler: 0
    EXPECT_EQ(mesh->positions.size(),
              WeldedPoints(*input_.state->plan, *input_.state->control_points,
                           SurfacePatterns(*input_.state->plan, segments))
                  .count());
  }
}

// Without welding, patches are those of chunks: each with all points of its pattern, in pattern order.
TEST_F(ExportTest, PatchesApartHaveVerticesOfTheirOwn) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8)), 0.2);
  const ViewSpec spec{.segments = 3, .normals = NormalMode::kSmooth};
  const auto apart = ExactSurface(input_, spec, NeverStop, Welding::kNone);
  const auto welded = ExactSurface(input_, spec, NeverStop);
  ASSERT_OK(apart);
  ASSERT_OK(welded);
  const auto& pattern = TessellationPattern::Get(3);
  const size_t patches = input_.state->plan->patches.size();
  ASSERT_EQ(apart->positions.size(), patches * 10);
  ASSERT_EQ(apart->face_count(), patches * 9);
  for (size_t c = 0; c < apart->corner_count(); ++c) {
    const size_t triangle = c / 3;
    ASSERT_EQ(apart->corner_vertices[c],
              triangle / 9 * 10 + pattern.triangles[triangle % 9][c % 3]);
    ASSERT_EQ(apart->positions[apart->corner_vertices[c]],
              welded->positions[welded->corner_vertices[c]]);
  }
}

// Neighbours have different patterns. Each edge still belongs to two triangles.
TEST_F(ExportTest, ATorusByToleranceIsOneClosedSurface) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8)), 0.2);
  size_t last = 0;
  for (const double tolerance : {3e-2, 3e-3, 3e-4}) {
    SCOPED_TRACE(tolerance);
    double certified_error = 0;
    const auto mesh =
        ExactSurface(input_, {.segments = 32, .tolerance = tolerance, .normals = NormalMode::kNone},
                     NeverStop, Welding::kShared, &certified_error);
    ASSERT_OK(mesh);
    ASSERT_OK(Validate(*mesh));
    const auto edges = EdgeUses(*mesh);
    for (const auto& [edge, uses] : edges) ASSERT_EQ(uses, 2) << edge.first << ' ' << edge.second;
    EXPECT_EQ(mesh->positions.size() + mesh->face_count(), edges.size());  // Euler: 0
    EXPECT_GT(mesh->face_count(), last);
    last = mesh->face_count();
    EXPECT_GT(certified_error, 0);
    EXPECT_LE(certified_error, tolerance);
  }
}

// The grid of a DRC file is part of the certified error.
TEST_F(ExportTest, ADracoFileCertifiesItsRounding) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8)), 0.2);
  const auto certified = [&](std::optional<MeshFormat> format, int bits) {
    const auto file = ExportSurface(
        input_, {.format = format, .segments = 32, .tolerance = 1e-2, .position_bits = bits},
        NeverStop);
    EXPECT_OK(file);
    return file->certified_error;
  };
  const double ply = certified(MeshFormat::kPly, 16), coarse = certified(MeshFormat::kDraco, 10);
  EXPECT_GT(ply, 0);
  EXPECT_LE(ply, 1e-2);
  EXPECT_GT(coarse, input_.state->box.step(10) / 2);
  EXPECT_LE(coarse, 1e-2);
  EXPECT_EQ(certified(std::nullopt, 16), 0) << "control nets are exact";
}

// The lattice holds half of the torus; its face tears off.
TEST_F(ExportTest, ATornSeamHasBothPlaces) {
  auto mesh = std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8));
  Bounds half = mesh->ComputeBounds();
  half.max.x = 0.1;
  ASSERT_OK_AND_ASSIGN(const Lattice lattice, FitLattice(half, {3, 3, 3}, {2, 2, 2}, 0));
  const auto closed = testing::MakeInput(render_backend_, mesh, lattice);
  ASSERT_OK(closed);
  Lattice moved = lattice;
  for (Vec3d& p : moved.control_points) p = p + Vec3d{-1, 0, 0};
  const auto torn = testing::MakeInput(render_backend_, mesh, moved);
  ASSERT_OK(torn);

  const auto whole =
      ExactSurface(*closed, {.segments = 3, .normals = NormalMode::kNone}, NeverStop);
  const auto parts = ExactSurface(*torn, {.segments = 3, .normals = NormalMode::kNone}, NeverStop);
  ASSERT_OK(whole);
  ASSERT_OK(parts);
  for (const auto& [edge, uses] : EdgeUses(*whole)) ASSERT_EQ(uses, 2);
  size_t open = 0;
  for (const auto& [edge, uses] : EdgeUses(*parts)) open += uses == 1 ? 1 : 0;
  EXPECT_GT(open, 0u);
  // Two loops around the tube, and each is there twice.
  EXPECT_EQ(parts->positions.size() - whole->positions.size(), open / 2);
  EXPECT_EQ(ToFloat(parts->ComputeBounds().min).x, ToFloat(whole->ComputeBounds().min).x - 1);
  EXPECT_LE(parts->positions.size(), WeldedPoints::Most(*torn->state->plan, 3));
}

TEST_F(ExportTest, UvsAreInterpolatedAndGroupsKept) {
  const auto mesh = ExactSurface(input_, {.segments = 4, .normals = NormalMode::kNone}, NeverStop);

  ASSERT_OK(mesh);
  EXPECT_TRUE(mesh->normals.empty());
  EXPECT_EQ(mesh->uvs.size(), mesh->positions.size());  // no seams
  for (size_t c = 0; c < mesh->corner_count(); ++c) {
    const Vec2f uv = mesh->uvs[mesh->corner_uvs[c]];
    const Vec3d position = mesh->positions[mesh->corner_vertices[c]];
    ASSERT_NEAR(double{uv.x}, position.x, 1e-6);
    ASSERT_NEAR(double{uv.y}, position.y, 1e-6);
  }
  EXPECT_EQ(mesh->group_names, (std::vector<std::string>{"left", "right"}));
  ASSERT_EQ(mesh->face_groups.size(), mesh->face_count());
  for (size_t t = 0; t < mesh->face_count(); ++t) {
    double x = 0;
    for (size_t i = 0; i < 3; ++i) {
      x += mesh->positions[mesh->corner_vertices[3 * t + i]].x / 3;
    }
    ASSERT_EQ(mesh->face_groups[t], x < 0.5 ? 0u : 1u);
  }
}

TEST_F(ExportTest, AnOriginalMeshIsMovedAndOtherwiseTheSame) {
  Make(TexturedGrid(), 0.2);
  const PolygonMesh& source = *input_.state->plan->mesh;
  const auto mesh = OriginalMesh(*input_.state, NormalMode::kSmooth, true, NeverStop);

  ASSERT_OK(mesh);
  ASSERT_OK(Validate(*mesh));
  EXPECT_EQ(mesh->face_offsets, source.face_offsets);
  EXPECT_EQ(mesh->corner_vertices, source.corner_vertices);
  EXPECT_EQ(mesh->uvs, source.uvs);
  EXPECT_EQ(mesh->corner_uvs, source.corner_uvs);
  EXPECT_EQ(mesh->face_groups, source.face_groups);
  for (size_t v = 0; v < source.positions.size(); ++v) {
    const DeformedPoint wanted = EvaluateWorld(input_.state->plan->structure,
                                               *input_.state->control_points, source.positions[v]);
    ASSERT_EQ(mesh->positions[v], wanted.position);
    ASSERT_NE(mesh->positions[v], source.positions[v]);
  }
  for (size_t c = 0; c < mesh->corner_count(); ++c) {
    const DeformedPoint at =
        EvaluateWorld(input_.state->plan->structure, *input_.state->control_points,
                      source.positions[source.corner_vertices[c]]);
    const Vec3d wanted = Unit(ApplyCofactor(at.jacobian, {0, 0, 1}));  // the grid is flat
    ASSERT_LE(Norm(ToDouble(mesh->normals[mesh->corner_normals[c]]) - wanted), 1e-6);
  }
  EXPECT_EQ(mesh->normals.size(), source.positions.size());
}

// The exact surface is that of the triangles at rest, so a deformed face must not be divided otherwise.
TEST_F(ExportTest, TrianglesOfAnOriginalMeshAreThoseOfTheScene) {
  Make(TexturedGrid(), 0.3);
  const auto mesh = OriginalMesh(*input_.state, NormalMode::kFacet, false, NeverStop);
  ASSERT_OK(mesh);
  EXPECT_TRUE(mesh->normals.empty());
  ASSERT_OK_AND_ASSIGN(const auto at_rest, Triangulated(*input_.state->plan->mesh));
  EXPECT_EQ(mesh->corner_vertices, at_rest.corner_vertices);
}

TEST_F(ExportTest, ControlNetsBeginAndEndAtTheCorners) {
  Make(TexturedGrid(), 0.2);
  const auto bytes = WriteControlNets(input_, NeverStop);
  ASSERT_OK(bytes);

  const DeformPlan& plan = *input_.state->plan;
  const size_t m = 7 * 8 / 2;  // degree 2 + 3 + 1
  ASSERT_EQ(bytes->size(), 32 + plan.patches.size() * m * 24);
  EXPECT_EQ(bytes->substr(0, 8), "LATTNETS");
  uint32_t header[4];
  std::memcpy(header, bytes->data() + 8, sizeof(header));
  EXPECT_EQ(header[0], 1u);
  EXPECT_EQ(header[1], 6u);
  EXPECT_EQ(header[2], m);
  uint64_t patches = 0;
  std::memcpy(&patches, bytes->data() + 24, sizeof(patches));
  EXPECT_EQ(patches, plan.patches.size());
  const DirectFfd direct(plan, *input_.state->control_points);
  const auto net_point = [&](size_t patch, size_t index) {
    Vec3d p;
    std::memcpy(&p, bytes->data() + 32 + (patch * m + index) * 24, sizeof(p));
    return p;
  };
  for (size_t patch = 0; patch < plan.patches.size(); ++patch) {
    ASSERT_LE(Norm(net_point(patch, 0) - direct.EvaluatePosition(patch, {1, 0, 0}).position), 1e-5);
    ASSERT_LE(Norm(net_point(patch, m - 1) - direct.EvaluatePosition(patch, {0, 0, 1}).position),
              1e-5);
  }
}

TEST_F(ExportTest, StopsWhenCancelled) {
  const auto at_once = [] { return absl::CancelledError("it is too late"); };
  EXPECT_THAT(ExportSurface(input_, {.format = MeshFormat::kPly}, at_once),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(
      ExportSurface(input_, {.format = MeshFormat::kGlb, .geometry = ExportGeometry::kOriginal},
                    at_once),
      StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(ExportSurface(input_, {.format = std::nullopt}, at_once),
              StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace latticed
