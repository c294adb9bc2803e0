// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/vertex_normals.h"

#include <tuple>

#include "absl/container/flat_hash_map.h"
#include "core/base/status_macros.h"

namespace latticed {
namespace {

// Newell's area vector: exact for planar polygons of any shape, sensible for others. It is computed relative to the
// first corner, so that distance from the origin costs no digits.
Vec3d AreaVector(const PolygonMesh& mesh, size_t face) {
  const uint32_t begin = mesh.face_offsets[face], end = mesh.face_offsets[face + 1];
  const Vec3d origin = mesh.positions[mesh.corner_vertices[begin]];
  Vec3d sum;
  for (uint32_t c = begin + 1; c + 1 < end; ++c) {
    sum += Cross(mesh.positions[mesh.corner_vertices[c]] - origin,
                 mesh.positions[mesh.corner_vertices[c + 1]] - origin);
  }
  return sum;
}

Vec3f UnitFloat(Vec3d n) { return ToFloat(n / Norm(n)); }

}  // namespace

absl::StatusOr<std::vector<Vec3f>> UnitCornerNormals(const PolygonMesh& mesh, StopCheck stop) {
  StopPoll poll(stop);
  std::vector<Vec3d> area(mesh.face_count());
  absl::flat_hash_map<std::tuple<double, double, double>, Vec3d> around;
  around.reserve(mesh.positions.size());
  const auto sum_at = [&](uint32_t corner) -> Vec3d& {
    const Vec3d p = mesh.positions[mesh.corner_vertices[corner]];
    return around[{p.x + 0.0, p.y + 0.0, p.z + 0.0}];
  };
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    area[f] = AreaVector(mesh, f);
    for (uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      sum_at(c) += area[f];
    }
  }
  std::vector<Vec3f> normals(mesh.corner_count());
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    for (uint32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      Vec3d given;
      if (mesh.has_normals() && mesh.corner_normals[c] != PolygonMesh::kNoAttribute) {
        given = ToDouble(mesh.normals[mesh.corner_normals[c]]);
      }
      if (Norm(given) > 0) {
        normals[c] = UnitFloat(given);
      } else if (const Vec3d sum = sum_at(c); Norm(sum) > 0) {
        normals[c] = UnitFloat(sum);
      } else if (Norm(area[f]) > 0) {
        normals[c] = UnitFloat(area[f]);
      } else {
        normals[c] = {0, 0, 1};
      }
    }
  }
  return normals;
}

}  // namespace latticed
