// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/meshes/mesh_files.h"

#include <algorithm>
#include <array>

#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/triangle_mesh.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

enum class PlyForm { kAscii, kLittleEndian, kBigEndian };

template <typename T>
std::string Number(T value, PlyForm form) {
  std::string bytes = BytesOf(std::vector<T>{value});
  if (form == PlyForm::kBigEndian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::vector<float> FloatPositions(const TriangleMesh& mesh) {
  std::vector<float> numbers;
  for (const Vec3d p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(p[axis]));
  }
  return numbers;
}

// The unit cube of 8 vertices and 12 triangles, facing outwards.
TriangleMesh Cube() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back({double(i & 1), double((i >> 1) & 1), double(i >> 2)});
  }
  constexpr std::array<std::array<uint32_t, 4>, 6> kQuads = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& q : kQuads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

// `positions` holds x y z of every vertex as float32.
std::string Ply(PlyForm form, const std::vector<float>& positions,
                const std::vector<std::vector<int32_t>>& faces) {
  constexpr std::array<std::string_view, 3> kForms{"ascii", "binary_little_endian",
                                                   "binary_big_endian"};
  std::string text = fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      kForms[size_t(form)], positions.size() / 3, faces.size());
  for (size_t i = 0; i < positions.size(); ++i) {
    text += form == PlyForm::kAscii ? fmt::format("{}{}", positions[i], i % 3 == 2 ? '\n' : ' ')
                                    : Number(positions[i], form);
  }
  for (const auto& face : faces) {
    if (form == PlyForm::kAscii) {
      text += fmt::format("{} {}\n", face.size(), fmt::join(face, " "));
      continue;
    }
    text += static_cast<char>(face.size());
    for (const int32_t vertex : face) text += Number(vertex, form);
  }
  return text;
}

std::string AsciiStl(const std::vector<std::string>& vertices) {
  std::string text = "solid part\n";
  for (size_t i = 0; i < vertices.size(); ++i) {
    if (i % 3 == 0) text += "facet normal 0 0 0\nouter loop\n";
    text += "vertex " + vertices[i] + "\n";
    if (i % 3 == 2) text += "endloop\nendfacet\n";
  }
  return text + "endsolid part\n";
}

MeshFile RawCube(const TriangleMesh& cube) {
  std::vector<uint32_t> corners;
  for (const auto& triangle : cube.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  MeshFile file =
      MakeMeshFile("RAW", v1::MESH_FORMAT_RAW, BytesOf(FloatPositions(cube)) + BytesOf(corners));
  v1::RawLayout& layout = *file.header.mutable_raw_layout();
  layout.set_vertex_count(cube.positions.size());
  layout.set_face_count(cube.triangles.size());
  layout.set_face_size(3);
  return file;
}

}  // namespace

MeshFile MakeMeshFile(const std::string& name, v1::MeshFormat format, std::string bytes) {
  MeshFile file{name, {}, std::move(bytes)};
  file.header.set_name(name);
  file.header.set_format(format);
  file.header.set_total_bytes(file.bytes.size());
  return file;
}

std::vector<MeshFile> CubeFiles() {
  const TriangleMesh cube = Cube();
  std::vector<std::vector<int32_t>> faces;
  std::vector<std::string> stl_vertices;
  for (const auto& t : cube.triangles) {
    faces.push_back({int32_t(t[0]), int32_t(t[1]), int32_t(t[2])});
    for (const uint32_t v : t) {
      const Vec3d p = cube.positions[v];
      stl_vertices.push_back(fmt::format("{} {} {}", p.x, p.y, p.z));
    }
  }
  const std::vector<float> positions = FloatPositions(cube);
  const auto written = [&](MeshFormat format) { return WriteMesh(format, Welded(cube)).value(); };
  return {
      MakeMeshFile("OBJ", v1::MESH_FORMAT_OBJ, written(MeshFormat::kObj)),
      MakeMeshFile("ascii PLY", v1::MESH_FORMAT_PLY, Ply(PlyForm::kAscii, positions, faces)),
      MakeMeshFile("little-endian PLY", v1::MESH_FORMAT_PLY, written(MeshFormat::kPly)),
      MakeMeshFile("big-endian PLY", v1::MESH_FORMAT_PLY,
                   Ply(PlyForm::kBigEndian, positions, faces)),
      MakeMeshFile("ascii STL", v1::MESH_FORMAT_STL, AsciiStl(stl_vertices)),
      MakeMeshFile("binary STL", v1::MESH_FORMAT_STL, written(MeshFormat::kStl)),
      MakeMeshFile("GLB", v1::MESH_FORMAT_GLB, written(MeshFormat::kGlb)),
      MakeMeshFile("DRACO", v1::MESH_FORMAT_DRACO, WriteDracoMesh(Welded(cube)).value()),
      RawCube(cube),
  };
}

}  // namespace latticed::testing
