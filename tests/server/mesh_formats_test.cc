// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes of every format go up, both ways, come back byte by byte, and carry scenes.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/sha256.h"
#include "core/mesh/mesh_io.h"
#include "fmt/format.h"
#include "tests/server/mesh_files.h"
#include "tests/server/test_env.h"

namespace latticed::testing {
namespace {

// Triangles of one update, in the world.
struct Surface {
  uint64_t revision = 0;
  std::vector<Vec3d> corners;  // 3 a triangle

  double Area() const {
    double area = 0;
    for (size_t c = 0; c < corners.size(); c += 3) {
      area += 0.5 * Norm(Cross(corners[c + 1] - corners[c], corners[c + 2] - corners[c]));
    }
    return area;
  }
};

class MeshFormatsTest : public ::testing::Test {
 protected:
  void ExpectOk(const grpc::Status& status) { ASSERT_TRUE(status.ok()) << status.error_message(); }

  // BeginUpload, AppendUpload in parts of 100 bytes, FinishUpload.
  grpc::Status UploadResumably(const MeshFile& file, v1::Mesh* mesh) {
    v1::BeginUploadRequest begin;
    *begin.mutable_header() = file.header;
    v1::BeginUploadResponse begun;
    grpc::ClientContext begin_context, finish_context;
    grpc::Status status = env_.meshes().BeginUpload(&begin_context, begin, &begun);
    for (size_t at = 0; status.ok() && at < file.bytes.size(); at += 100) {
      v1::AppendUploadRequest append;
      append.set_upload_id(begun.upload_id());
      append.set_offset(at);
      append.set_data(file.bytes.substr(at, 100));
      v1::AppendUploadResponse appended;
      grpc::ClientContext context;
      status = env_.meshes().AppendUpload(&context, append, &appended);
    }
    if (!status.ok()) return status;
    v1::FinishUploadRequest finish;
    finish.set_upload_id(begun.upload_id());
    return env_.meshes().FinishUpload(&finish_context, finish, mesh);
  }

  std::string Download(const std::string& mesh) {
    v1::DownloadMeshRequest request;
    request.set_mesh(mesh);
    grpc::ClientContext context;
    const auto reader = env_.meshes().DownloadMesh(&context, request);
    v1::DownloadMeshResponse part;
    std::string bytes;
    while (reader->Read(&part)) bytes += part.data();
    ExpectOk(reader->Finish());
    return bytes;
  }

  // A scene on the mesh, all of it lifted by 3.
  std::string LiftedScene(const std::string& mesh) {
    const std::string id = fmt::format("scene-number-{}", ++scenes_);
    v1::CreateSceneRequest create;
    create.set_scene_id(id);
    create.set_mesh(mesh);
    create.mutable_default_view()->set_segments(2);
    create.mutable_default_view()->set_encoding(v1::ENCODING_RAW);
    create.mutable_default_view()->set_normals(v1::NORMAL_MODE_NONE);
    v1::Scene scene;
    grpc::ClientContext create_context, edit_context;
    ExpectOk(env_.scenes().CreateScene(&create_context, create, &scene));
    v1::EditBatch batch;
    batch.set_scene(id);
    batch.set_editor_id("ann");
    batch.set_sequence(1);
    batch.set_structure_id(1);
    auto& move = *batch.add_edits()->mutable_move_control_points();
    for (uint32_t i = 0; i < 64; ++i) move.add_indices(i);
    move.mutable_offset()->set_z(3);
    v1::EditResult result;
    ExpectOk(env_.scenes().ApplyEdits(&edit_context, batch, &result));
    return id;
  }

  Surface Evaluate(const std::string& scene) {
    v1::GetUpdateRequest request;
    request.set_scene(scene);
    grpc::ClientContext context;
    const auto reader = env_.scenes().GetUpdate(&context, request);
    v1::SceneEvent event;
    v1::Topology topology;
    Vec3d origin;
    std::vector<Vec3d> points;
    Surface surface;
    while (reader->Read(&event)) {
      if (event.has_topology()) topology = event.topology();
      if (event.has_quantisation()) {
        const v1::Vec3& o = event.quantisation().origin();
        origin = {o.x(), o.y(), o.z()};
      }
      if (event.has_update_end()) surface.revision = event.update_end().revision();
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        std::vector<float> numbers(chunk.data().size() / sizeof(float));
        std::memcpy(numbers.data(), chunk.data().data(), chunk.data().size());
        for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
          points.push_back(origin + Vec3d{numbers[i], numbers[i + 1], numbers[i + 2]});
        }
      }
    }
    ExpectOk(reader->Finish());
    EXPECT_EQ(points.size(), topology.point_count());
    const size_t per_patch = static_cast<size_t>(topology.pattern().points_size()) / 3;
    for (size_t p = 0; p < points.size(); p += per_patch) {
      for (const uint32_t t : topology.pattern().triangles()) {
        surface.corners.push_back(points[p + t]);
      }
    }
    return surface;
  }

  // The whole unit cube, lifted by 3, and nothing else.
  void ExpectLiftedCube(const std::string& mesh, double tolerance) {
    const Surface surface = Evaluate(LiftedScene(mesh));
    EXPECT_EQ(surface.revision, 1u);
    EXPECT_NEAR(surface.Area(), 6, 6 * tolerance);
    double farthest = 0;
    for (const Vec3d p : surface.corners) {
      const Vec3d q = p - Vec3d{0.5, 0.5, 3.5};
      farthest = std::max(farthest,
                          std::abs(std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)}) - 0.5));
    }
    EXPECT_LE(farthest, tolerance);
  }

  PolygonMesh ExportObj(const std::string& scene) {
    v1::ExportRequest request;
    request.set_scene(scene);
    request.set_format(v1::EXPORT_FORMAT_OBJ);
    request.mutable_view()->set_segments(1);
    request.mutable_view()->set_normals(v1::NORMAL_MODE_SMOOTH);
    grpc::ClientContext context;
    const auto reader = env_.scenes().Export(&context, request);
    v1::ExportResponse part;
    std::string bytes;
    while (reader->Read(&part)) bytes += part.data();
    ExpectOk(reader->Finish());
    return ReadObj(bytes).value();
  }

  TestEnv env_;
  int scenes_ = 0;
};

TEST_F(MeshFormatsTest, EveryFormatGoesUpComesBackAndIsDeformed) {
  for (const MeshFile& file : CubeFiles()) {
    SCOPED_TRACE(file.name);
    v1::Mesh mesh;
    ExpectOk(env_.Upload(file.header, file.bytes, &mesh));

    EXPECT_EQ(mesh.id(), Sha256Hex(file.bytes));
    EXPECT_EQ(mesh.format(), file.header.format());
    EXPECT_EQ(mesh.vertices(), 8u);
    EXPECT_EQ(mesh.faces(), 12u);
    EXPECT_EQ(mesh.corners(), 36u);
    EXPECT_NEAR(mesh.bounds().min().z(), 0, 1e-6);
    EXPECT_NEAR(mesh.bounds().max().x(), 1, 1e-6);
    EXPECT_FALSE(mesh.has_normals());
    EXPECT_FALSE(mesh.has_uvs());
    EXPECT_EQ(Download(mesh.id()), file.bytes);
    ExpectLiftedCube(mesh.id(), 1e-5);
  }
}

TEST_F(MeshFormatsTest, ResumableUploadsMakeTheSameMeshes) {
  for (const MeshFile& file : CubeFiles()) {
    SCOPED_TRACE(file.name);
    v1::Mesh resumed, streamed, got;
    ExpectOk(UploadResumably(file, &resumed));

    EXPECT_EQ(resumed.vertices(), 8u);
    EXPECT_EQ(resumed.faces(), 12u);
    ExpectOk(env_.Upload(file.header, file.bytes, &streamed));
    EXPECT_EQ(streamed.SerializeAsString(), resumed.SerializeAsString());
    grpc::ClientContext context;
    v1::GetMeshRequest request;
    request.set_mesh(resumed.id());
    ExpectOk(env_.meshes().GetMesh(&context, request, &got));
    EXPECT_EQ(got.SerializeAsString(), resumed.SerializeAsString());
    EXPECT_EQ(Download(resumed.id()), file.bytes);
  }
}

// A pyramid: a square of side 2 and four triangles, mixed face sizes; u = x / 2, v = y / 2.
MeshFile RawPyramid(v1::AttributeDomain domain) {
  const std::vector<double> positions = {0.1, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 1, 1, 1};
  const std::vector<uint32_t> sizes = {4, 3, 3, 3, 3};
  const std::vector<uint32_t> corners = {0, 3, 2, 1, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
  const std::vector<uint32_t> groups = {1, 0, 0, 0, 0};
  std::vector<float> normals, uvs;
  const auto add = [&](uint32_t vertex) {
    normals.insert(normals.end(), {0, 0, 1});
    uvs.push_back(static_cast<float>(positions[3 * vertex] / 2));
    uvs.push_back(static_cast<float>(positions[3 * vertex + 1] / 2));
  };
  if (domain == v1::ATTRIBUTE_DOMAIN_CORNER) {
    for (const uint32_t vertex : corners) add(vertex);
  } else {
    for (uint32_t vertex = 0; vertex < 5; ++vertex) add(vertex);
  }
  MeshFile file = MakeMeshFile("pyramid", v1::MESH_FORMAT_RAW,
                               BytesOf(positions) + BytesOf(sizes) + BytesOf(corners) +
                                   BytesOf(normals) + BytesOf(uvs) + BytesOf(groups));
  v1::RawLayout& layout = *file.header.mutable_raw_layout();
  layout.set_vertex_count(5);
  layout.set_face_count(5);
  layout.set_corner_count(16);
  layout.set_position_type(v1::SCALAR_TYPE_FLOAT64);
  layout.set_normals(domain);
  layout.set_uvs(domain);
  layout.add_group_names("sides");
  layout.add_group_names("base");
  return file;
}

TEST_F(MeshFormatsTest, RawOfMixedFacesInDoubleWithAttributesPerVertexAndPerCorner) {
  for (const auto domain : {v1::ATTRIBUTE_DOMAIN_VERTEX, v1::ATTRIBUTE_DOMAIN_CORNER}) {
    SCOPED_TRACE(v1::AttributeDomain_Name(domain));
    const MeshFile file = RawPyramid(domain);
    v1::Mesh mesh;
    ExpectOk(env_.Upload(file.header, file.bytes, &mesh));

    EXPECT_EQ(mesh.vertices(), 5u);
    EXPECT_EQ(mesh.faces(), 5u);
    EXPECT_EQ(mesh.corners(), 16u);
    EXPECT_TRUE(mesh.has_normals());
    EXPECT_TRUE(mesh.has_uvs());
    ASSERT_EQ(mesh.groups_size(), 2);
    EXPECT_EQ(mesh.groups(0).faces(), 4u);
    EXPECT_EQ(mesh.groups(1).name(), "base");
    EXPECT_EQ(mesh.groups(1).faces(), 1u);
    EXPECT_EQ(Download(mesh.id()), file.bytes);

    const std::string scene = LiftedScene(mesh.id());
    EXPECT_EQ(Evaluate(scene).revision, 1u);
    const PolygonMesh exported = ExportObj(scene);
    ASSERT_TRUE(exported.has_uvs());
    ASSERT_TRUE(exported.has_normals());
    EXPECT_EQ(exported.group_names.size(), 2u);
    for (size_t c = 0; c < exported.corner_count(); ++c) {
      const Vec3d p = exported.positions[exported.corner_vertices[c]];
      const Vec2f uv = exported.uvs[exported.corner_uvs[c]];
      EXPECT_NEAR(uv.x, p.x / 2, 1e-5);
      EXPECT_NEAR(uv.y, p.y / 2, 1e-5);
      EXPECT_NEAR(exported.normals[exported.corner_normals[c]].z, 1, 1e-5);
    }
  }
}

TEST_F(MeshFormatsTest, RawPositionsInDoubleKeepEveryBit) {
  const MeshFile file = RawPyramid(v1::ATTRIBUTE_DOMAIN_VERTEX);
  MeshFile far = file;
  const double x = 1e9 + 1.0 / 1024;  // no float
  std::memcpy(far.bytes.data() + 3 * sizeof(double), &x, sizeof(x));
  v1::Mesh mesh;
  ExpectOk(env_.Upload(far.header, far.bytes, &mesh));

  EXPECT_EQ(mesh.bounds().max().x(), x);
  EXPECT_EQ(mesh.bounds().min().x(), 0);
}

}  // namespace
}  // namespace latticed::testing
