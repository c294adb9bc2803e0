// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/triangulated.h"

#include <array>
#include <vector>

#include "core/base/status_macros.h"
#include "core/mesh/triangulate.h"
#include "fmt/format.h"

namespace latticed {
namespace {

size_t TriangleCount(const PolygonMesh& mesh) {
  return mesh.corner_count() - 2 * mesh.face_count();  // n - 2 of a face with n corners
}

// Everything but the corners and faces.
PolygonMesh WithoutFaces(const PolygonMesh& mesh) {
  PolygonMesh result;
  result.positions = mesh.positions;
  result.normals = mesh.normals;
  result.uvs = mesh.uvs;
  result.group_names = mesh.group_names;
  const size_t triangles = TriangleCount(mesh);
  result.face_offsets.reserve(triangles + 1);
  result.corner_vertices.reserve(3 * triangles);
  if (mesh.has_normals()) result.corner_normals.reserve(3 * triangles);
  if (mesh.has_uvs()) result.corner_uvs.reserve(3 * triangles);
  if (!mesh.face_groups.empty()) result.face_groups.reserve(triangles);
  return result;
}

void AppendCorner(const PolygonMesh& mesh, uint32_t corner, PolygonMesh* out) {
  out->corner_vertices.push_back(mesh.corner_vertices[corner]);
  if (mesh.has_normals()) out->corner_normals.push_back(mesh.corner_normals[corner]);
  if (mesh.has_uvs()) out->corner_uvs.push_back(mesh.corner_uvs[corner]);
}

}  // namespace

bool IsTriangular(const PolygonMesh& mesh) {
  return mesh.corner_count() == 3 * mesh.face_count();  // no face has fewer than three
}

absl::StatusOr<PolygonMesh> Triangulated(const PolygonMesh& mesh, StopCheck stop) {
  PolygonMesh result = WithoutFaces(mesh);
  StopPoll poll(stop);
  std::vector<Vec3d> polygon;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (size_t face = 0; face < mesh.face_count(); ++face) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    const uint32_t first = mesh.face_offsets[face], end = mesh.face_offsets[face + 1];
    polygon.clear();
    for (uint32_t c = first; c < end; ++c) {
      polygon.push_back(mesh.positions[mesh.corner_vertices[c]]);
    }
    if (const auto status = TriangulatePolygon(polygon, &triangles, stop); !status.ok()) {
      if (IsStopped(status)) return status;
      return absl::Status(status.code(), fmt::format("face {} has {} corners, and {}", face,
                                                     end - first, std::string(status.message())));
    }
    for (const auto& triangle : triangles) {
      for (const uint32_t corner : triangle) AppendCorner(mesh, first + corner, &result);
      result.face_offsets.push_back(static_cast<uint32_t>(result.corner_count()));
      if (!mesh.face_groups.empty()) result.face_groups.push_back(mesh.face_groups[face]);
    }
  }
  return result;
}

}  // namespace latticed
