// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_io.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::string Header(const TriangleMesh& mesh) {
  std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment latticed\n{}element vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n",
      mesh.units.known() ? fmt::format("comment {}\n", Describe(mesh.units)) : "",
      mesh.positions.size());
  if (!mesh.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.uvs.empty()) header += "property float s\nproperty float t\n";
  header += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                        mesh.triangles.size());
  return header;
}

}  // namespace

std::string WritePly(const TriangleMesh& mesh) {
  std::string out = Header(mesh);
  const size_t vertex_bytes = sizeof(Vec3f) + (mesh.normals.empty() ? 0 : sizeof(Vec3f)) +
                              (mesh.uvs.empty() ? 0 : sizeof(Vec2f));
  const size_t triangle_bytes = sizeof(uint8_t) + 3 * sizeof(uint32_t);
  out.reserve(out.size() + vertex_bytes * mesh.positions.size() +
              triangle_bytes * mesh.triangles.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    AppendLittleEndian(ToFloat(mesh.positions[i]), &out);
    if (!mesh.normals.empty()) AppendLittleEndian(mesh.normals[i], &out);
    if (!mesh.uvs.empty()) AppendLittleEndian(mesh.uvs[i], &out);
  }
  for (const auto& triangle : mesh.triangles) {
    AppendLittleEndian(uint8_t{3}, &out);
    AppendLittleEndian(triangle, &out);
  }
  return out;
}

}  // namespace latticed
