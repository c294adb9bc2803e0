// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The dispatch by format, and whole meshes (samples, and real models if present), written to and
// read from every format.
#include "core/mesh/mesh_io.h"

#include <map>
#include <string>
#include <utility>

#include "core/mesh/sample_meshes.h"
#include "core/mesh/triangulated.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"
#include "tests/support/real_meshes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::IsMalformed;
using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

constexpr MeshFormat kFormats[] = {MeshFormat::kObj, MeshFormat::kPly, MeshFormat::kStl,
                                   MeshFormat::kGlb};

// Every corner must come back in its place, to float precision. Without groups, by which GLB orders triangles.
void ExpectSurvivesEveryFormat(PolygonMesh mesh) {
  mesh.group_names.clear();
  mesh.face_groups.clear();
  ASSERT_OK_AND_ASSIGN(const auto triangles, Triangulated(mesh));
  const std::vector<Vec3d> wanted = testing::CornerPositions(triangles);
  const double tolerance =
      1e-6 * (mesh.ComputeBounds().diagonal() + Norm(mesh.ComputeBounds().center()));
  for (MeshFormat format : kFormats) {
    SCOPED_TRACE(MeshFormatName(format));
    ASSERT_OK_AND_ASSIGN(const auto bytes, WriteMesh(format, triangles));
    ASSERT_OK_AND_ASSIGN(const auto read, ReadMesh(format, bytes));
    const std::vector<Vec3d> got = testing::CornerPositions(read);
    ASSERT_EQ(got.size(), wanted.size());
    double worst = 0;
    for (size_t c = 0; c < got.size(); ++c) worst = std::max(worst, Norm(got[c] - wanted[c]));
    EXPECT_LE(worst, tolerance);
  }
}

TEST(MeshIoTest, FormatsGoByFileNameInAnyCase) {
  EXPECT_EQ(MeshFormatFromFileName("a/b.c/model.OBJ").value(), MeshFormat::kObj);
  EXPECT_EQ(MeshFormatFromFileName("x.ply").value(), MeshFormat::kPly);
  EXPECT_EQ(MeshFormatFromFileName("x.Stl").value(), MeshFormat::kStl);
  EXPECT_EQ(MeshFormatFromFileName("x.glb").value(), MeshFormat::kGlb);
  EXPECT_EQ(MeshFormatFromFileName("x.drc").value(), MeshFormat::kDraco);
  for (const char* name : {"x.gltf", "obj", "", "x.", "x.obj.gz"}) {
    EXPECT_THAT(MeshFormatFromFileName(name),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr(".obj, .ply, .stl, .glb and .drc, and to write .usda")));
  }
  for (MeshFormat format : kFormats) {
    EXPECT_EQ(MeshFormatFromFileName("x." + std::string(MeshFormatExtension(format))).value(),
              format);
  }
}

TEST(MeshIoTest, EmptyFilesAreRefusedInEveryFormat) {
  for (MeshFormat format : kFormats)
    EXPECT_THAT(ReadMesh(format, ""), IsMalformed("byte 0: it is empty"));
}

TEST(MeshIoTest, OneFormatReadAsAnotherIsRefused) {
  for (MeshFormat written : kFormats) {
    ASSERT_OK_AND_ASSIGN(const auto bytes, WriteMesh(written, testing::SquareOfTwoGroups()));
    for (MeshFormat read : kFormats) {
      if (read == written) continue;
      EXPECT_THAT(ReadMesh(read, bytes), IsMalformed("not a valid"))
          << MeshFormatName(written) << " as " << MeshFormatName(read);
    }
  }
}

TEST(MeshIoTest, DracoIsForTheCodec) {
  EXPECT_THAT(ReadMesh(MeshFormat::kDraco, "DRACO"), StatusIs(absl::StatusCode::kUnimplemented));
  EXPECT_THAT(WriteMesh(MeshFormat::kDraco, {}), StatusIs(absl::StatusCode::kUnimplemented));
}

TEST(MeshIoTest, UsdIsWrittenOnly) {
  EXPECT_EQ(MeshFormatFromFileName("x.usda").value(), MeshFormat::kUsd);
  EXPECT_THAT(ReadMesh(MeshFormat::kUsd, "#usda 1.0"), StatusIs(absl::StatusCode::kUnimplemented));
}

TEST(MeshIoTest, SamplesSurviveEveryFormat) {
  for (std::string_view name : SampleMeshNames()) {
    SCOPED_TRACE(name);
    ASSERT_OK_AND_ASSIGN(const auto mesh, MakeSampleMesh(name, 2));
    ExpectSurvivesEveryFormat(mesh);
  }
}

TEST(MeshIoTest, RealModelsAreReadWholeAndSurviveEveryFormat) {
  const std::map<std::string, std::pair<size_t, size_t>> vertices_and_faces{
      {"fandisk", {6475, 12946}},
      {"rocker-arm", {10044, 20088}},
      {"spot", {2930, 5856}},
      {"stanford-bunny", {35947, 69451}},
      {"teapot", {3644, 6320}}};
  const std::vector<testing::RealMesh> meshes = testing::RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    if (const auto known = vertices_and_faces.find(name); known != vertices_and_faces.end()) {
      EXPECT_EQ(std::pair(mesh.positions.size(), mesh.face_count()), known->second);
    }
    ExpectSurvivesEveryFormat(mesh);
  }
}

TEST(MeshIoTest, GlbTurnsEveryUpAxisToYAndScalesToMetres) {
  const struct {
    const char* up;
    Vec3d x, y, z;  // images of the axes, scaled by half a metre per unit
  } cases[] = {{"x", {0, 0.5, 0}, {-0.5, 0, 0}, {0, 0, 0.5}},
               {"y", {0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}},
               {"z", {0.5, 0, 0}, {0, 0, -0.5}, {0, 0.5, 0}},
               {"", {0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}};
  for (const auto& axes : cases) {
    PolygonMesh mesh;
    mesh.positions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.face_offsets = {0, 3};
    mesh.corner_vertices = {0, 1, 2};
    ASSERT_OK_AND_ASSIGN(const auto bytes,
                         WriteMesh(MeshFormat::kGlb, mesh, {.units = {axes.up, 0.5}}));
    ASSERT_OK_AND_ASSIGN(const auto read, ReadMesh(MeshFormat::kGlb, bytes));
    EXPECT_EQ(read.positions, (std::vector<Vec3d>{axes.x, axes.y, axes.z})) << axes.up;
  }
}

TEST(MeshIoTest, OfAGlbUnknownUnitsAreThoseOfGltf) {
  EXPECT_EQ(Describe(WithGltfDefaults({})), "up +y, 1 m per unit");
  EXPECT_EQ(Describe(WithGltfDefaults({"z", 0})), "up +z, 1 m per unit");
  EXPECT_EQ(Describe(WithGltfDefaults({"", 0.01})), "up +y, 0.01 m per unit");
}

TEST(MeshIoTest, KnownUnitsAreACommentThatReadersPassOver) {
  for (const MeshFormat format : {MeshFormat::kObj, MeshFormat::kPly, MeshFormat::kStl}) {
    const PolygonMesh mesh = testing::SquareOfTwoGroups();
    ASSERT_OK_AND_ASSIGN(const auto bytes, WriteMesh(format, mesh, {.units = {"z", 0.0254}}));
    EXPECT_THAT(bytes.substr(0, 100), HasSubstr("up +z, 0.0254 m per unit"));
    ASSERT_OK_AND_ASSIGN(const auto read, ReadMesh(format, bytes));
    EXPECT_EQ(testing::CornerPositions(read), testing::CornerPositions(mesh));
  }
}

}  // namespace
}  // namespace latticed
