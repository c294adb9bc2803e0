// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Exported surfaces compared with the definition in double, their UVs and groups, control nets, and
// exports that are cancelled.
#include <cstring>

#include "core/cpu/cpu_backend.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "server/engine/surface_export.h"
#include "tests/server/scenes/export_input.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

const Cancelled kNever = [] { return false; };

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

TEST_F(ExportTest, VerticesMatchTheDefinition) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(12, 8, {100, 0, -50})), 0.2);
  const auto mesh = AssembleSurface(input_, 3, NormalMode::kFacet, kNever);
  ASSERT_OK(mesh);

  const DeformPlan& plan = *input_.state->plan;
  const DirectFfd direct(plan, *input_.state->control_points);
  const auto& pattern = TessellationPattern::Get(3);
  ASSERT_EQ(mesh->positions.size(), plan.patches.size() * 10);
  ASSERT_EQ(mesh->triangles.size(), plan.patches.size() * 9);
  Bounds bounds;
  for (const Vec3d p : mesh->positions) bounds.Extend(p);
  for (size_t patch = 0; patch < plan.patches.size(); ++patch) {
    for (size_t q = 0; q < 10; ++q) {
      const auto& p = pattern.points[q];
      const auto expected =
          direct.Evaluate(patch, {p[0] / 3.0, p[1] / 3.0, p[2] / 3.0}, DirectFfd::Normal::kFacet);
      const size_t vertex = patch * 10 + q;
      ASSERT_LE(Norm(mesh->positions[vertex] - expected.position), 1e-6 * bounds.diagonal());
      ASSERT_NEAR(Norm(ToDouble(mesh->normals[vertex])), 1, 1e-6);
    }
  }
}

TEST_F(ExportTest, UvsAreInterpolatedAndGroupsKept) {
  const auto mesh = AssembleSurface(input_, 4, NormalMode::kNone, kNever);

  ASSERT_OK(mesh);
  EXPECT_TRUE(mesh->normals.empty());
  ASSERT_EQ(mesh->uvs.size(), mesh->positions.size());
  for (size_t i = 0; i < mesh->uvs.size(); ++i) {
    ASSERT_NEAR(double{mesh->uvs[i].x}, mesh->positions[i].x, 1e-6);
    ASSERT_NEAR(double{mesh->uvs[i].y}, mesh->positions[i].y, 1e-6);
  }
  EXPECT_EQ(mesh->group_names, (std::vector<std::string>{"left", "right"}));
  ASSERT_EQ(mesh->triangle_groups.size(), mesh->triangles.size());
  for (size_t t = 0; t < mesh->triangles.size(); ++t) {
    double x = 0;
    for (const uint32_t v : mesh->triangles[t]) x += mesh->positions[v].x / 3;
    ASSERT_EQ(mesh->triangle_groups[t], x < 0.5 ? 0u : 1u);
  }
}

TEST_F(ExportTest, ControlNetsBeginAndEndAtTheCorners) {
  Make(TexturedGrid(), 0.2);
  const auto bytes = WriteControlNets(input_, kNever);
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
  const Cancelled at_once = [] { return true; };
  EXPECT_THAT(ExportSurface(input_, {.format = MeshFormat::kPly}, at_once),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_THAT(ExportSurface(input_, {.format = std::nullopt}, at_once),
              StatusIs(absl::StatusCode::kCancelled));
}

}  // namespace
}  // namespace latticed
