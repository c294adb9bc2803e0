// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How vertices are shared: records of formats without separate indices, and the welding of tessellations.
#include "core/mesh/write/vertex_records.h"

#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/mesh/short_edges.h"
#include "core/mesh/triangle_mesh.h"
#include "core/mesh/triangulated.h"
#include "core/mesh/vertex_values.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr uint32_t kNone = PolygonMesh::kNoAttribute;

TEST(VertexRecordsTest, WithoutAttributesTheyAreThePositions) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {9, 9, 9}, {0, 1, 0}};  // no corner has the third
  mesh.face_offsets = {0, 3};
  mesh.corner_vertices = {3, 0, 1};
  const VertexRecords vertices = MakeVertexRecords(mesh);
  EXPECT_EQ(vertices.records.size(), 4u);
  EXPECT_THAT(vertices.corner_records, ElementsAre(3, 0, 1));
}

TEST(VertexRecordsTest, AVertexHasOneForEachPairOfAttributes) {
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.corner_normals = {0, 1, 2, 3, 2, 1};  // corner 3 has another normal at vertex 0
  mesh.corner_uvs = {0, 1, 2, 0, kNone, 3};  // corner 4 has none at vertex 2
  const VertexRecords vertices = MakeVertexRecords(mesh);
  EXPECT_THAT(vertices.records,
              ElementsAre(VertexRecord{0, 0, 0}, VertexRecord{0, 3, 0}, VertexRecord{1, 1, 1},
                          VertexRecord{2, 2, 2}, VertexRecord{2, 2, kNone}, VertexRecord{3, 1, 3}));
  EXPECT_THAT(vertices.corner_records, ElementsAre(0, 2, 3, 1, 4, 5));
  EXPECT_EQ(UvOf(mesh, vertices.records[4]), (Vec2f{0, 0}));
}

// 200,000 corners with texture coordinates of their own at one vertex: a search of all would take minutes.
TEST(VertexRecordsTest, TheHubOfAFanTakesNoLongerThanOtherVertices) {
  PolygonMesh fan;
  constexpr uint32_t kTriangles = 200'000;
  fan.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (uint32_t t = 0; t < kTriangles; ++t) {
    fan.uvs.push_back({static_cast<float>(t), 0});
    fan.corner_vertices.insert(fan.corner_vertices.end(), {0, 1, 2});
    fan.corner_uvs.insert(fan.corner_uvs.end(), 3, t);
    fan.face_offsets.push_back(3 * (t + 1));
  }
  const absl::Time start = absl::Now();
  const VertexRecords vertices = MakeVertexRecords(fan);
  EXPECT_EQ(vertices.records.size(), 3 * size_t{kTriangles});
  VertexValues<Vec2f> values(3, fan.uvs.size());
  for (const Vec2f uv : fan.uvs) values.Add(0, uv);
  EXPECT_EQ(std::move(values).Take().size(), fan.uvs.size());
  EXPECT_LT(absl::Now() - start, absl::Seconds(5));
}

// Two triangles that were made apart: the points of their edge are the same, its normals nearly.
TriangleMesh TwoTriangles(Vec3f normal) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, normal, normal, normal};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

TEST(WeldedTest, PointsOfAnEdgeBecomeOne) {
  const PolygonMesh mesh = Welded(TwoTriangles({1e-5f, 0, 1}));
  EXPECT_OK(Validate(mesh));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.normals.size(), 4u);
  EXPECT_EQ(mesh.uvs.size(), 4u);
  EXPECT_EQ(MakeVertexRecords(mesh).records.size(), 4u);
}

TEST(WeldedTest, ACreaseIsOfNormalsAlone) {
  const PolygonMesh mesh = Welded(TwoTriangles({0.6f, 0, 0.8f}));
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.normals.size(), 6u);
  EXPECT_EQ(MakeVertexRecords(mesh).records.size(), 6u);
}

// The sliver between the second and the third vertex has its first two corners at one place.
TEST(WeldedTest, ASliverGoesAndItsNeighboursMeet) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}};
  mesh.normals = std::vector<Vec3f>(5, {0, 0, 1});
  mesh.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 4, 3}};
  mesh.group_names = {"a", "sliver", "b"};
  mesh.triangle_groups = {0, 1, 2};
  const PolygonMesh welded = Welded(mesh);
  EXPECT_OK(Validate(welded));
  EXPECT_THAT(welded.corner_vertices, ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(welded.face_groups, ElementsAre(0, 2));
}

TEST(ShortEdgesTest, OnlyVerticesThatAnEdgeJoinsBecomeOne) {
  PolygonMesh mesh;  // a chain of three near (1, 0, 0), and another part that touches there
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1e-7, 0}, {1, 0, 1e-7},
                    {0, 1, 0}, {1, 0, 0}, {3, 0, 0},    {3, 1, 0}};
  mesh.corner_vertices = {0, 1, 4, 2, 1, 4, 3, 2, 0, 5, 6, 7};
  mesh.face_offsets = {0, 3, 6, 9, 12};
  CollapseShortEdges(mesh);
  EXPECT_OK(Validate(mesh));
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(mesh.positions.size(), 6u);
}

// 1,000 triangles side by side, each a tenth of the least length wide.
TEST(ShortEdgesTest, AChainOfThemDoesNotBecomeOnePoint) {
  PolygonMesh mesh;
  constexpr uint32_t kCount = 1'000;
  const double step = ShortEdgeLength({{0, 0, 0}, {1, 1, 0}}) / 10;
  for (uint32_t i = 0; i <= kCount; ++i) mesh.positions.push_back({i * step, 0, 0});
  mesh.positions.push_back({1, 1, 0});
  for (uint32_t i = 0; i < kCount; ++i) {
    mesh.corner_vertices.insert(mesh.corner_vertices.end(), {i, i + 1, kCount + 1});
    mesh.face_offsets.push_back(3 * (i + 1));
  }
  CollapseShortEdges(mesh);
  EXPECT_OK(Validate(mesh));
  EXPECT_GT(mesh.face_count(), kCount / 20);
  EXPECT_LT(mesh.face_count(), kCount / 5);
}

TEST(ShortEdgesTest, AMeshOfNothingElseStays) {
  PolygonMesh mesh;
  mesh.positions = {{5, 5, 5}, {5, 5, 5}, {5, 5, 5}};
  mesh.corner_vertices = {0, 1, 2};
  mesh.face_offsets = {0, 3};
  CollapseShortEdges(mesh);
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2));
}

TEST(TriangulatedTest, TrianglesKeepTheAttributesOfTheirFace) {
  PolygonMesh quad;
  quad.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  quad.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  quad.face_offsets = {0, 4};
  quad.corner_vertices = {0, 1, 2, 3};
  quad.corner_uvs = {3, 2, 1, 0};
  quad.group_names = {"unused", "used"};
  quad.face_groups = {1};
  ASSERT_OK_AND_ASSIGN(const auto mesh, Triangulated(quad));
  EXPECT_OK(Validate(mesh));
  EXPECT_TRUE(IsTriangular(mesh));
  EXPECT_THAT(mesh.face_groups, ElementsAre(1, 1));
  EXPECT_THAT(mesh.corner_normals, IsEmpty());
  for (size_t c = 0; c < 6; ++c) EXPECT_EQ(mesh.corner_uvs[c], 3 - mesh.corner_vertices[c]);
}

}  // namespace
}  // namespace latticed
