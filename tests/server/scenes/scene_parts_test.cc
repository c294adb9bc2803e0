// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GetTopology and Export through the stub.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/base/limits.h"
#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/write/write_mesh.h"
#include "server/engine/scene/topology_id.h"
#include "server/wire/converters.h"
#include "tests/server/support/server_test.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class ScenePartsTest : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    v1::CreateSceneRequest request = SceneRequest();
    request.mutable_default_view()->set_segments(2);
    ASSERT_OK(Create(request, &scene_));
  }
  absl::Status Topology(const std::string& id, std::vector<v1::TopologyPart>& parts) {
    auto request = For<v1::GetTopologyRequest>();
    request.set_topology_id(id);
    return ReadAll(&Scenes::GetTopology, request, &parts);
  }
  absl::Status Export(v1::ExportRequest request, std::vector<v1::ExportResponse>& parts) {
    if (request.scene().empty()) request.set_scene(kScene);
    return ReadAll(&Scenes::Export, request, &parts);
  }
  std::string TopologyIdNow() {
    DeformPlan plan;
    plan.structure = *StructureFromProto(Lattice().lattice(), "lattice");
    return TopologyId(mesh_, plan, 2);
  }
  v1::Scene scene_;
};

TEST_F(ScenePartsTest, TopologyNamesEveryPatchsSource) {
  std::vector<v1::TopologyPart> parts;
  ASSERT_OK(Topology(TopologyIdNow(), parts));

  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].patch_count(), scene_.patches());
  EXPECT_EQ(static_cast<uint64_t>(parts[0].faces_size()), scene_.patches());
}

TEST_F(ScenePartsTest, TopologyOfAnotherStructureIsNotFound) {
  const std::string before = TopologyIdNow();
  ASSERT_OK(Apply(Knot("ann", 1)));

  std::vector<v1::TopologyPart> parts;
  ExpectRefused(Topology(before, parts), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(Topology("", parts), Code::kNotFound, "NOT_FOUND");
  EXPECT_TRUE(parts.empty());
  EXPECT_OK(Topology(TopologyIdNow(), parts));
}

TEST_F(ScenePartsTest, ExportsAreNamedByTheSceneInLettersThatFileSystemsTake) {
  v1::CreateSceneRequest named = SceneRequest("c");
  named.set_name("../Kuh: Ä");
  ASSERT_OK(Create(named));
  v1::ExportRequest request;
  request.set_scene("c");
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  EXPECT_EQ(parts[0].header().file_name(), "_._Kuh_ Ä-deformed.ply");
}

TEST_F(ScenePartsTest, ExportsEveryForm) {
  for (int f = v1::EXPORT_FORMAT_UNSPECIFIED; f <= v1::EXPORT_FORMAT_USD; ++f) {
    SCOPED_TRACE(f);
    v1::ExportRequest request;
    request.set_format(static_cast<v1::ExportFormat>(f));
    std::vector<v1::ExportResponse> parts;
    ASSERT_OK(Export(request, parts));
    ASSERT_GE(parts.size(), 2u);
    ASSERT_TRUE(parts[0].has_header());
    const v1::ExportHeader header = parts[0].header();
    EXPECT_EQ(header.revision(), 0u);
    EXPECT_THAT(header.file_name(), ::testing::StartsWith("cube-deformed."));
    EXPECT_THAT(header.media_type(), ::testing::HasSubstr("/"));
    std::string bytes;
    for (size_t i = 1; i < parts.size(); ++i) {
      ASSERT_LE(parts[i].data().size(), limits::kMaxPartBytes);
      bytes += parts[i].data();
    }
    ASSERT_EQ(bytes.size(), header.bytes());
    if (f == v1::EXPORT_FORMAT_CONTROL_NETS) {
      EXPECT_EQ(bytes.size(), 32 + scene_.patches() * 28 * 24);
      continue;
    }
    const auto format = MeshFormatFromFileName(header.file_name());
    ASSERT_OK(format);
    if (*format == MeshFormat::kUsd) {
      EXPECT_THAT(bytes, ::testing::StartsWith("#usda 1.0\n"));
      continue;
    }
    const auto mesh =
        *format == MeshFormat::kDraco ? ReadDracoMesh(bytes) : ReadMesh(*format, bytes);
    ASSERT_OK(mesh);
    EXPECT_EQ(mesh->face_count(), scene_.patches() * 4);
  }
}

TEST_F(ScenePartsTest, AnOriginalMeshIsTheUploadedOneMoved) {
  v1::EditBatch lift = Move("ann", 1, 0, 0);
  auto* all = lift.mutable_edits(0)->mutable_move_control_points();
  for (uint32_t i = 1; i < 64; ++i) all->add_indices(i);
  all->mutable_offset()->set_z(3);
  ASSERT_OK(Apply(lift));
  const auto uploaded = ReadObj(kGridObj);
  ASSERT_OK(uploaded);
  for (const auto format : {v1::EXPORT_FORMAT_OBJ, v1::EXPORT_FORMAT_PLY}) {
    v1::ExportRequest request;
    request.set_format(format);
    request.set_geometry(v1::EXPORT_GEOMETRY_ORIGINAL);
    std::vector<v1::ExportResponse> parts;
    ASSERT_OK(Export(request, parts));
    const auto mesh = ReadMesh(
        format == v1::EXPORT_FORMAT_OBJ ? MeshFormat::kObj : MeshFormat::kPly, parts.at(1).data());
    ASSERT_OK(mesh);

    EXPECT_EQ(mesh->face_offsets, uploaded->face_offsets);  // four quads
    EXPECT_EQ(mesh->corner_vertices, uploaded->corner_vertices);
    EXPECT_EQ(mesh->corner_uvs, uploaded->corner_uvs);
    EXPECT_EQ(mesh->uvs, uploaded->uvs);
    ASSERT_EQ(mesh->positions.size(), 9u);
    for (size_t v = 0; v < 9; ++v) {
      EXPECT_LE(Norm(mesh->positions[v] - uploaded->positions[v] - Vec3d{0, 0, 3}), 1e-6);
    }
    if (format == v1::EXPORT_FORMAT_PLY) continue;  // has no groups
    EXPECT_EQ(mesh->group_names, uploaded->group_names);
  }
}

// The patches of the grid share their vertices: of four quads in some boxes of a lattice, none is open inside.
TEST_F(ScenePartsTest, PatchesOfAnExportShareVertices) {
  v1::ExportRequest request;
  request.set_format(v1::EXPORT_FORMAT_PLY);
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  const auto mesh = ReadPly(parts.at(1).data());
  ASSERT_OK(mesh);
  // Euler: V - E + F = 1 of a disc, whose edges are (3 F + boundary) / 2.
  const size_t faces = mesh->face_count(), vertices = mesh->positions.size();
  EXPECT_EQ(faces, scene_.patches() * 4);
  EXPECT_LT(vertices, faces);
  std::set<std::pair<uint32_t, uint32_t>> edges;
  for (size_t c = 0; c < mesh->corner_count(); ++c) {
    const uint32_t a = mesh->corner_vertices[c];
    edges.insert(std::minmax(a, mesh->corner_vertices[c % 3 == 2 ? c - 2 : c + 1]));
  }
  EXPECT_EQ(vertices + faces, edges.size() + 1);
}

// A torus, exported by a tolerance: each edge of the file's triangles belongs to two faces.
TEST_F(ScenePartsTest, AnExportByToleranceIsClosed) {
  const PolygonMesh torus = TorusMesh(12, 8);
  mesh_ = Upload(*WriteMesh(MeshFormat::kObj, torus, {}));
  ASSERT_OK(Create(SceneRequest("torus")));
  v1::EditBatch bend = Move("ann", 1, 0, 0.5);
  bend.set_scene("torus");
  bend.mutable_edits(0)->mutable_move_control_points()->add_indices(21);
  ASSERT_OK(Apply(bend));
  auto request = For<v1::ExportRequest>("torus");
  request.set_format(v1::EXPORT_FORMAT_OBJ);
  request.mutable_view()->set_segments(32);
  size_t last = 0;
  for (const double tolerance : {0.05, 0.005, 0.0005}) {
    SCOPED_TRACE(tolerance);
    request.mutable_view()->set_tolerance(tolerance);
    std::vector<v1::ExportResponse> parts;
    ASSERT_OK(Export(request, parts));
    EXPECT_GT(parts.at(0).header().certified_error(), 0);
    EXPECT_LE(parts.at(0).header().certified_error(), tolerance);
    std::string bytes;
    for (const v1::ExportResponse& part : parts) bytes += part.data();
    const auto mesh = ReadObj(bytes);
    ASSERT_OK(mesh);
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (size_t c = 0; c < mesh->corner_count(); ++c) {
      const uint32_t a = mesh->corner_vertices[c];
      ++edges[std::minmax(a, mesh->corner_vertices[c % 3 == 2 ? c - 2 : c + 1])];
    }
    for (const auto& [edge, faces] : edges) ASSERT_EQ(faces, 2) << edge.first << ' ' << edge.second;
    EXPECT_GT(mesh->face_count(), last);
    last = mesh->face_count();
  }
}

TEST_F(ScenePartsTest, ToleranceOfADracoFileChoosesItsBits) {
  v1::ExportRequest request;
  request.set_format(v1::EXPORT_FORMAT_DRC);
  request.mutable_view()->set_tolerance(0.01);
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  const double certified = parts.at(0).header().certified_error();
  EXPECT_GT(certified, 0);
  EXPECT_LE(certified, 0.01);

  request.mutable_view()->set_position_bits(8);
  parts.clear();
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "OUT_OF_RANGE",
                "view.position_bits");
  request.set_format(v1::EXPORT_FORMAT_PLY);
  EXPECT_OK(Export(request, parts)) << "bits have no effect";
  request.mutable_view()->set_tolerance(1e-9);
  parts.clear();
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "OUT_OF_RANGE", "view.tolerance");
  request.set_geometry(v1::EXPORT_GEOMETRY_ORIGINAL);
  EXPECT_OK(Export(request, parts)) << "a tolerance has no effect";
  EXPECT_EQ(parts.at(0).header().certified_error(), 0);
}

TEST_F(ScenePartsTest, LargeExportsComeInParts) {
  v1::CreateSceneRequest finer = SceneRequest("scene-two");
  SetAxes(*finer.add_lattices()->mutable_fit()->mutable_size(), 9, 9, 3);
  ASSERT_OK(Create(finer));
  auto request = For<v1::ExportRequest>("scene-two");
  request.set_format(v1::EXPORT_FORMAT_OBJ);
  request.mutable_view()->set_segments(12);
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  EXPECT_GT(parts.size(), 2u);
}

TEST_F(ScenePartsTest, ExportRefusals) {
  std::vector<v1::ExportResponse> parts;
  v1::ExportRequest request;
  request.set_revision(7);
  ExpectRefused(Export(request, parts), Code::kAborted, "REVISION_CHANGED");
  request.set_revision(0);
  request.set_format(static_cast<v1::ExportFormat>(99));
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "UNSUPPORTED", "format");
  request.clear_format();
  request.mutable_view()->set_segments(99);
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "OUT_OF_RANGE", "view.segments");
  request.clear_view();
  request.set_geometry(static_cast<v1::ExportGeometry>(9));
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "UNSUPPORTED", "geometry");
  request.set_geometry(v1::EXPORT_GEOMETRY_ORIGINAL);
  request.set_format(v1::EXPORT_FORMAT_CONTROL_NETS);
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "INVALID_FIELD", "geometry");
  request.clear_geometry();
  request.set_scene("no-such-scene");
  ExpectRefused(Export(request, parts), Code::kNotFound, "NOT_FOUND");
  EXPECT_TRUE(parts.empty());
}

TEST_F(ScenePartsTest, AClientThatLeavesStopsTheExport) {
  auto request = For<v1::ExportRequest>();
  request.mutable_view()->set_segments(32);
  {
    grpc::ClientContext context;
    auto reader = scenes_->Export(&context, request);
    v1::ExportResponse first;
    ASSERT_TRUE(reader->Read(&first));
    context.TryCancel();
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export({}, parts));  // the server still answers
}

}  // namespace
}  // namespace latticed::testing
