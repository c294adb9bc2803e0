// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/sample_meshes.h"

#include <gmock/gmock.h>

#include <map>

#include "core/mesh/triangulate.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::FacePositions;
using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

// For each directed edge, its uses minus those of the opposite edge. Only positive counts are kept.
std::map<std::pair<uint32_t, uint32_t>, int> BoundaryEdges(const PolygonMesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> uses;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const uint32_t begin = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
    for (uint32_t c = begin; c < end; ++c) {
      const uint32_t a = mesh.corner_vertices[c];
      const uint32_t b = mesh.corner_vertices[c + 1 < end ? c + 1 : begin];
      ++uses[{a, b}];
      --uses[{b, a}];
    }
  }
  std::erase_if(uses, [](const auto& use) { return use.second <= 0; });
  return uses;
}

// By the divergence theorem. Positive for a closed mesh whose faces are oriented outward.
double Volume(const PolygonMesh& mesh) {
  double volume = 0;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const std::vector<Vec3d> face = FacePositions(mesh, f);
    std::vector<std::array<uint32_t, 3>> triangles;
    EXPECT_OK(TriangulatePolygon(face, &triangles));
    for (const auto& t : triangles) volume += Dot(face[t[0]], Cross(face[t[1]], face[t[2]])) / 6;
  }
  return volume;
}

TEST(SampleMeshesTest, AllAreValidAndAboutTwoUnitsAcross) {
  for (std::string_view name : SampleMeshNames()) {
    SCOPED_TRACE(name);
    ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh(name));
    EXPECT_OK(Validate(mesh));
    const Bounds bounds = mesh.ComputeBounds();
    EXPECT_GT(bounds.diagonal(), 1.5);
    EXPECT_LT(bounds.diagonal(), 4.0);
    EXPECT_LT(Norm(bounds.center()), 0.5);
    EXPECT_GE(mesh.face_count(), name == "beam" ? 18u : 1'600u);
  }
}

TEST(SampleMeshesTest, ClosedOnesAreClosedAndLookOutward) {
  for (std::string_view name : {"vase", "knot", "gear", "beam"}) {
    SCOPED_TRACE(name);
    ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh(name));
    EXPECT_TRUE(BoundaryEdges(mesh).empty());
    EXPECT_GT(Volume(mesh), 0.05);
  }
}

TEST(SampleMeshesTest, ShellIsOpenAtItsMouthOnly) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh("shell", 4));
  EXPECT_EQ(BoundaryEdges(mesh).size(), 24u);
  EXPECT_EQ(mesh.face_count(), 2u * 180 * 24 + 24);
}

TEST(SampleMeshesTest, KnotHasQuadsUvsAndNormals) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh("knot", 4));
  EXPECT_EQ(mesh.face_count(), 240u * 24);
  EXPECT_EQ(mesh.corner_count(), 4 * mesh.face_count());
  EXPECT_EQ(mesh.uvs.size(), 241u * 25);
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  for (size_t f = 0; f < mesh.face_count(); f += 97) {  // normals and faces are oriented alike
    const Vec3d n = NewellNormal(FacePositions(mesh, f));
    const uint32_t corner = mesh.face_offsets[f];
    ASSERT_GT(Dot(n, ToDouble(mesh.normals[mesh.corner_normals[corner]])), 0.8 * Norm(n));
  }
}

TEST(SampleMeshesTest, GearHasConcaveFacesAndGroups) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh("gear", 1));
  EXPECT_THAT(mesh.group_names, ::testing::ElementsAre("caps", "teeth", "bore"));
  EXPECT_EQ(mesh.face_offsets[1], 2u * (24 * 12 / 6 + 1));
  std::vector<std::array<uint32_t, 3>> triangles;
  const std::vector<Vec3d> cap = FacePositions(mesh, 0);
  EXPECT_OK(TriangulatePolygon(cap, &triangles));
  double area = 0;
  for (const auto& t : triangles) {
    area += Norm(Cross(cap[t[1]] - cap[t[0]], cap[t[2]] - cap[t[0]]));
  }
  EXPECT_NEAR(area, Norm(NewellNormal(cap)), 1e-12);
}

TEST(SampleMeshesTest, SlabIsASheetThatLooksUp) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh("slab", 4));
  EXPECT_EQ(mesh.face_count(), 40u * 40);
  EXPECT_EQ(mesh.uvs.size(), 41u * 41);
  EXPECT_EQ(BoundaryEdges(mesh).size(), 4u * 40);
  for (size_t f = 0; f < mesh.face_count(); f += 97) {
    ASSERT_GT(NewellNormal(FacePositions(mesh, f)).z, 0);
  }
}

TEST(SampleMeshesTest, BeamIsTheSameBoxOf18QuadsAtEveryResolution) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh("beam", 1));
  ASSERT_OK_AND_ASSIGN(const auto fine, MakeSampleMesh("beam", 64));
  EXPECT_EQ(mesh.positions.size(), 20u);
  EXPECT_EQ(mesh.face_count(), 18u);
  EXPECT_EQ(mesh.corner_count(), 4 * 18u);
  EXPECT_TRUE(mesh.has_uvs());
  EXPECT_EQ(mesh.positions, fine.positions);
  EXPECT_EQ(mesh.ComputeBounds().min, (Vec3d{-1, -0.125, -0.125}));
  EXPECT_EQ(mesh.ComputeBounds().max, (Vec3d{1, 0.125, 0.125}));
  EXPECT_NEAR(Volume(mesh), 2 * 0.25 * 0.25, 1e-15);
  for (size_t f = 0; f < mesh.face_count();
       ++f) {  // every face looks away from the x axis or an end
    const std::vector<Vec3d> face = FacePositions(mesh, f);
    const Vec3d middle = 0.25 * (face[0] + face[1] + face[2] + face[3]);
    const Vec3d normal = NewellNormal(face);
    EXPECT_GT(Dot(normal, f < 16 ? Vec3d{0, middle.y, middle.z} : middle), 0) << f;
  }
}

TEST(SampleMeshesTest, ResolutionRefines) {
  for (std::string_view name : SampleMeshNames()) {
    if (name == "beam") continue;
    ASSERT_OK_AND_ASSIGN(const auto coarse, MakeSampleMesh(name, kMinSampleResolution));
    ASSERT_OK_AND_ASSIGN(const auto fine, MakeSampleMesh(name, 2));
    EXPECT_GT(fine.face_count(), 3 * coarse.face_count()) << name;
  }
}

TEST(SampleMeshesTest, RefusesOtherNamesAndResolutions) {
  EXPECT_THAT(MakeSampleMesh("teapot"), StatusIs(absl::StatusCode::kInvalidArgument,
                                                 HasSubstr("vase, knot, gear, shell, slab, beam")));
  EXPECT_THAT(MakeSampleMesh("vase", 0),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("1 to 64")));
  EXPECT_THAT(MakeSampleMesh("vase", 65), StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace latticed
