// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/mesh.h"

#include <array>
#include <utility>

#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

absl::Status Contradiction() {
  return absl::DataLossError("the topology contradicts the points or the mesh");
}

absl::Status CheckProvenance(const PolygonMesh& source, size_t patch_count,
                             const v1::TopologyPart& provenance) {
  const auto patches = static_cast<int64_t>(patch_count);
  if (provenance.faces_size() != patches || provenance.corners_size() != 3 * patches ||
      provenance.barycentrics_size() != 9 * patches) {
    return Contradiction();
  }
  for (const uint32_t face : provenance.faces()) {
    if (face >= source.face_count()) return Contradiction();
  }
  for (const uint32_t corner : provenance.corners()) {
    if (corner >= source.corner_count()) return Contradiction();
  }
  return absl::OkStatus();
}

// Texture coordinates of the three corners of a patch. A corner without any gets (0, 0).
std::array<Vec2f, 3> PatchUvs(const PolygonMesh& source, const v1::TopologyPart& provenance,
                              int patch) {
  std::array<Vec2f, 3> result;
  for (int c = 0; c < 3; ++c) {
    double u = 0, v = 0;
    for (int k = 0; k < 3; ++k) {
      const uint32_t uv = source.corner_uvs[provenance.corners(3 * patch + k)];
      if (uv == PolygonMesh::kNoAttribute) continue;
      const double weight = provenance.barycentrics(9 * patch + 3 * c + k);
      u += weight * double{source.uvs[uv].x};
      v += weight * double{source.uvs[uv].y};
    }
    result[static_cast<size_t>(c)] = {static_cast<float>(u), static_cast<float>(v)};
  }
  return result;
}

void CarryUvs(const PolygonMesh& source, std::span<const PatchLayout> layouts,
              const v1::TopologyPart& provenance, TriangleMesh* mesh) {
  mesh->uvs.reserve(mesh->positions.size());
  for (int patch = 0; patch < provenance.faces_size(); ++patch) {
    const std::array<Vec2f, 3> corner = PatchUvs(source, provenance, patch);
    const PatchLayout& layout = layouts[static_cast<size_t>(patch)];
    const float scale = 1.0f / static_cast<float>(layout.denominator);
    for (size_t p = 0; p < layout.points.size(); p += 3) {
      Vec2f uv;
      for (size_t c = 0; c < 3; ++c) {
        const float weight = static_cast<float>(layout.points[p + c]) * scale;
        uv.x += weight * corner[c].x;
        uv.y += weight * corner[c].y;
      }
      mesh->uvs.push_back(uv);
    }
  }
}

}  // namespace

absl::StatusOr<TriangleMesh> AssembleMesh(std::span<const PatchLayout> layouts,
                                          DecodedPoints points) {
  size_t point_count = 0, triangle_count = 0;
  for (const PatchLayout& layout : layouts) {
    point_count += layout.point_count();
    triangle_count += layout.triangle_count();
  }
  if (points.positions.size() != point_count) return Contradiction();
  TriangleMesh mesh;
  mesh.positions = std::move(points.positions);
  mesh.normals = std::move(points.normals);
  mesh.triangles.reserve(triangle_count);
  uint32_t first = 0;
  for (const PatchLayout& layout : layouts) {
    const std::span<const uint32_t> corners = layout.triangles;
    for (size_t t = 0; t < corners.size(); t += 3) {
      mesh.triangles.push_back(
          {first + corners[t], first + corners[t + 1], first + corners[t + 2]});
    }
    first += static_cast<uint32_t>(layout.point_count());
  }
  return mesh;
}

absl::Status CarryAttributes(const PolygonMesh& source, std::span<const PatchLayout> layouts,
                             const v1::TopologyPart& provenance, TriangleMesh* mesh) {
  LATTICED_RETURN_IF_ERROR(CheckProvenance(source, layouts.size(), provenance));
  if (source.has_uvs()) CarryUvs(source, layouts, provenance, mesh);
  if (source.face_groups.empty()) return absl::OkStatus();
  mesh->group_names = source.group_names;
  mesh->triangle_groups.reserve(mesh->triangles.size());
  for (size_t patch = 0; patch < layouts.size(); ++patch) {
    const uint32_t face = provenance.faces(static_cast<int>(patch));
    mesh->triangle_groups.insert(mesh->triangle_groups.end(), layouts[patch].triangle_count(),
                                 source.face_groups[face]);
  }
  return absl::OkStatus();
}

}  // namespace latticed::client
