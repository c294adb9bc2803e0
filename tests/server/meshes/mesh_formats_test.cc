// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes of every format are uploaded, downloaded byte by byte, and deformed in scenes.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/sha256.h"
#include "core/mesh/mesh_io.h"
#include "fmt/format.h"
#include "tests/server/meshes/mesh_files.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

// The triangles of one update, in world coordinates.
struct Surface {
  uint64_t revision = 0;
  std::vector<Vec3d> corners;  // 3 per triangle

  double Area() const {
    double area = 0;
    for (size_t c = 0; c < corners.size(); c += 3) {
      area += 0.5 * Norm(Cross(corners[c + 1] - corners[c], corners[c + 2] - corners[c]));
    }
    return area;
  }
};

class MeshFormatsTest : public SmallServerTest {
 protected:
  std::string Download(const std::string& mesh) {
    v1::DownloadMeshRequest request;
    request.set_mesh(mesh);
    std::vector<v1::DownloadMeshResponse> parts;
    EXPECT_OK(ReadAll(&Meshes::DownloadMesh, request, &parts));
    std::string bytes;
    for (const auto& part : parts) bytes += part.data();
    return bytes;
  }

  // Creates a scene of the mesh and moves all of it by 3 along z.
  std::string LiftedScene(const std::string& mesh) {
    const std::string id = fmt::format("scene-number-{}", ++count_);
    mesh_ = mesh;
    v1::CreateSceneRequest create = SceneRequest(id);
    create.mutable_default_view()->set_segments(2);
    create.mutable_default_view()->set_encoding(v1::ENCODING_RAW);
    create.mutable_default_view()->set_normals(v1::NORMAL_MODE_NONE);
    EXPECT_OK(Create(create));
    v1::EditBatch batch = MoveOne("ann", 1, 0, {0, 0, 3});
    batch.set_scene(id);
    auto& move = *batch.mutable_edits(0)->mutable_move_control_points();
    for (uint32_t i = 1; i < 64; ++i) move.add_indices(i);
    EXPECT_OK(Apply(batch));
    return id;
  }

  Surface Evaluate(const std::string& scene) {
    EventLog log;
    EXPECT_OK(Update(For<v1::GetUpdateRequest>(scene), log));
    const v1::Topology& topology = log.topologies.at(0);
    const v1::Vec3& origin = log.quantisations.at(0).origin();
    std::vector<Vec3d> points;
    for (const auto& [index, data] : log.chunks) {
      std::vector<float> numbers(data.size() / sizeof(float));
      std::memcpy(numbers.data(), data.data(), data.size());
      for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
        points.push_back(Vec3d{origin.x(), origin.y(), origin.z()} +
                         Vec3d{numbers[i], numbers[i + 1], numbers[i + 2]});
      }
    }
    Surface surface{.revision = log.ends.at(0).revision(), .corners = {}};
    EXPECT_EQ(points.size(), topology.point_count());
    const size_t per_patch = static_cast<size_t>(topology.pattern().points_size()) / 3;
    for (size_t p = 0; p < points.size(); p += per_patch) {
      for (const uint32_t t : topology.pattern().triangles()) {
        surface.corners.push_back(points[p + t]);
      }
    }
    return surface;
  }

  // Expects the whole unit cube, moved by 3 along z, and nothing else.
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
    auto request = For<v1::ExportRequest>(scene);
    request.set_format(v1::EXPORT_FORMAT_OBJ);
    request.mutable_view()->set_segments(1);
    request.mutable_view()->set_normals(v1::NORMAL_MODE_SMOOTH);
    return ReadObj(Export(request).value()).value();
  }

  int count_ = 0;
};

TEST_F(MeshFormatsTest, EveryFormatGoesUpComesBackAndIsDeformed) {
  for (const MeshFile& file : CubeFiles()) {
    SCOPED_TRACE(file.name);
    v1::Mesh mesh;
    EXPECT_OK(Upload(file.header, file.bytes, &mesh));

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

// A pyramid: a quad and four triangles; u = x / 2, v = y / 2.
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
    EXPECT_OK(Upload(file.header, file.bytes, &mesh));

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
  const double x = 1e9 + 1.0 / 1024;  // not a float
  std::memcpy(far.bytes.data() + 3 * sizeof(double), &x, sizeof(x));
  v1::Mesh mesh;
  EXPECT_OK(Upload(far.header, far.bytes, &mesh));

  EXPECT_EQ(mesh.bounds().max().x(), x);
  EXPECT_EQ(mesh.bounds().min().x(), 0);
}

}  // namespace
}  // namespace latticed::testing
