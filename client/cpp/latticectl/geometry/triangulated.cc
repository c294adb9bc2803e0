// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/triangulated.h"

#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/mesh/triangulate.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// Appends the vertices of `result`. Returns each corner's vertex.
std::vector<uint32_t> AddVertices(const PolygonMesh& mesh, TriangleMesh& result) {
  if (!mesh.has_uvs()) {
    result.positions = mesh.positions;
    return mesh.corner_vertices;
  }
  absl::flat_hash_map<std::pair<uint32_t, uint32_t>, uint32_t> ids;
  std::vector<uint32_t> vertex_of_corner;
  vertex_of_corner.reserve(mesh.corner_count());
  for (size_t c = 0; c < mesh.corner_count(); ++c) {
    const uint32_t vertex = mesh.corner_vertices[c], uv = mesh.corner_uvs[c];
    const auto [it, added] =
        ids.try_emplace({vertex, uv}, static_cast<uint32_t>(result.positions.size()));
    if (added) {
      result.positions.push_back(mesh.positions[vertex]);
      result.uvs.push_back(uv == PolygonMesh::kNoAttribute ? Vec2f{} : mesh.uvs[uv]);
    }
    vertex_of_corner.push_back(it->second);
  }
  return vertex_of_corner;
}

}  // namespace

absl::StatusOr<TriangleMesh> Triangulated(const PolygonMesh& mesh) {
  TriangleMesh result{.group_names = mesh.group_names};
  const std::vector<uint32_t> vertices = AddVertices(mesh, result);
  std::vector<Vec3d> polygon;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (size_t face = 0; face < mesh.face_count(); ++face) {
    const uint32_t first = mesh.face_offsets[face], end = mesh.face_offsets[face + 1];
    polygon.clear();
    for (uint32_t c = first; c < end; ++c) {
      polygon.push_back(mesh.positions[mesh.corner_vertices[c]]);
    }
    if (const auto status = TriangulatePolygon(polygon, &triangles); !status.ok()) {
      return absl::Status(status.code(), fmt::format("face {} has {} corners, and {}", face,
                                                     end - first, std::string(status.message())));
    }
    for (const auto& [a, b, c] : triangles) {
      result.triangles.push_back({vertices[first + a], vertices[first + b], vertices[first + c]});
      if (!mesh.face_groups.empty()) result.triangle_groups.push_back(mesh.face_groups[face]);
    }
  }
  return result;
}

}  // namespace latticed::client
