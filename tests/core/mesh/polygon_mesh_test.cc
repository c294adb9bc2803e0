// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/polygon_mesh.h"

#include <limits>

#include "core/base/limits.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

PolygonMesh Quad() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, -3}};
  mesh.face_offsets = {0, 4};
  mesh.corner_vertices = {0, 1, 2, 3};
  mesh.normals = {{0, 0, 1}};
  mesh.corner_normals = {0, 0, PolygonMesh::kNoAttribute, 0};
  mesh.uvs = {{0, 0}, {1, 1}};
  mesh.corner_uvs = {0, 1, 1, PolygonMesh::kNoAttribute};
  mesh.group_names = {"only"};
  mesh.face_groups = {0};
  return mesh;
}

TEST(PolygonMeshTest, AValidMeshPasses) { EXPECT_OK(Validate(Quad())); }

TEST(PolygonMeshTest, BoundsHoldAllVerticesOfFaces) {
  PolygonMesh mesh = Quad();
  mesh.positions.push_back({100, 100, 100});  // on no face
  const Bounds bounds = mesh.ComputeBounds();
  EXPECT_EQ(bounds.min, (Vec3d{0, 0, -3}));
  EXPECT_EQ(bounds.max, (Vec3d{2, 1, 0}));
  EXPECT_TRUE(PolygonMesh().ComputeBounds().empty());
}

TEST(PolygonMeshTest, MemoryGrowsWithTheMesh) {
  PolygonMesh mesh = Quad();
  const size_t before = mesh.MemoryBytes();
  mesh.positions.resize(1'000);
  EXPECT_GE(mesh.MemoryBytes(), before + 996 * sizeof(Vec3d));
}

// A valid mesh with one fault, and the message of its refusal.
struct Broken {
  void (*change)(PolygonMesh*);
  const char* message;
};
class BrokenMeshTest : public ::testing::TestWithParam<Broken> {};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(
    All, BrokenMeshTest,
    ::testing::Values(
        Broken{[](PolygonMesh* m) { *m = {}; }, "no faces"},
        Broken{[](PolygonMesh* m) { m->face_offsets.clear(); }, "face_offsets"},
        Broken{[](PolygonMesh* m) {
                 m->face_offsets = {0, 3};
               },
               "face_offsets"},
        Broken{[](PolygonMesh* m) {
                 m->face_offsets = {0, 5, 4}, m->face_groups = {0, 0};
               },
               "face_offsets decrease at face 1"},
        Broken{[](PolygonMesh* m) {
                 m->face_offsets = {0, 2, 4}, m->face_groups = {0, 0};
               },
               "face 0 has 2 corners; 3 are needed"},
        Broken{[](PolygonMesh* m) {
                 m->corner_vertices.resize(limits::kMaxFaceCorners + 1);
                 m->corner_normals.resize(limits::kMaxFaceCorners + 1);
                 m->corner_uvs.resize(limits::kMaxFaceCorners + 1);
                 m->face_offsets = {0, limits::kMaxFaceCorners + 1};
               },
               "at most 65536 are allowed"},
        Broken{[](PolygonMesh* m) { m->corner_vertices[3] = 4; },
               "corner 3 has the vertex index 4"},
        Broken{[](PolygonMesh* m) { m->corner_vertices[0] = PolygonMesh::kNoAttribute; },
               "corner 0 has the vertex index"},
        Broken{[](PolygonMesh* m) { m->corner_normals[1] = 1; }, "corner 1 has the normal index 1"},
        Broken{[](PolygonMesh* m) { m->corner_uvs[2] = 2; }, "corner 2 has the texture coordinate"},
        Broken{[](PolygonMesh* m) { m->corner_normals.pop_back(); }, "corner_normals has 3"},
        Broken{[](PolygonMesh* m) { m->uvs.clear(); }, "corner_uvs has 4 entries instead of 0"},
        Broken{[](PolygonMesh* m) { m->face_groups.clear(); }, "face_groups has 0"},
        Broken{[](PolygonMesh* m) { m->face_groups[0] = 1; }, "face 0 has the group index 1"},
        Broken{[](PolygonMesh* m) { m->positions[2].y = kNan; }, "vertex 2 is not finite"},
        Broken{[](PolygonMesh* m) { m->positions[1].x = -2e15; }, "vertex 1 is farther than 1e+15"},
        Broken{[](PolygonMesh* m) { m->normals[0].z = static_cast<float>(kNan); },
               "normal 0 is not"},
        Broken{[](PolygonMesh* m) { m->uvs[1].x = std::numeric_limits<float>::infinity(); },
               "texture coordinate 1 is not finite"}));

TEST_P(BrokenMeshTest, IsRefusedByName) {
  PolygonMesh mesh = Quad();
  GetParam().change(&mesh);
  EXPECT_THAT(Validate(mesh),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message)));
}

}  // namespace
}  // namespace latticed
