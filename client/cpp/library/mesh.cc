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

absl::Status CheckProvenance(const PolygonMesh& source, const v1::Topology& topology,
                             const v1::TopologyPart& provenance) {
  const auto patches = static_cast<int64_t>(topology.patch_count());
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

void CarryUvs(const PolygonMesh& source, const v1::Topology& topology,
              const v1::TopologyPart& provenance, TriangleMesh* mesh) {
  const auto& pattern = topology.pattern().points();
  const float scale = 1.0f / static_cast<float>(topology.segments());
  mesh->uvs.reserve(topology.point_count());
  for (int patch = 0; patch < provenance.faces_size(); ++patch) {
    const std::array<Vec2f, 3> corner = PatchUvs(source, provenance, patch);
    for (int p = 0; p + 2 < pattern.size(); p += 3) {
      Vec2f uv;
      for (int c = 0; c < 3; ++c) {
        const float weight = static_cast<float>(pattern[p + c]) * scale;
        uv.x += weight * corner[static_cast<size_t>(c)].x;
        uv.y += weight * corner[static_cast<size_t>(c)].y;
      }
      mesh->uvs.push_back(uv);
    }
  }
}

}  // namespace

absl::StatusOr<TriangleMesh> AssembleMesh(const v1::Topology& topology, DecodedPoints points) {
  const auto& pattern = topology.pattern();
  const auto points_per_patch = static_cast<uint32_t>(pattern.points_size() / 3);
  if (points.positions.size() != topology.point_count() ||
      topology.point_count() != topology.patch_count() * points_per_patch) {
    return Contradiction();
  }
  for (const uint32_t point : pattern.triangles()) {
    if (point >= points_per_patch) return Contradiction();
  }
  TriangleMesh mesh;
  mesh.positions = std::move(points.positions);
  mesh.normals = std::move(points.normals);
  mesh.triangles.reserve(topology.triangle_count());
  for (uint64_t patch = 0; patch < topology.patch_count(); ++patch) {
    const auto first = static_cast<uint32_t>(patch * points_per_patch);
    for (int t = 0; t + 2 < pattern.triangles_size(); t += 3) {
      mesh.triangles.push_back({first + pattern.triangles(t), first + pattern.triangles(t + 1),
                                first + pattern.triangles(t + 2)});
    }
  }
  return mesh;
}

absl::Status CarryAttributes(const PolygonMesh& source, const v1::Topology& topology,
                             const v1::TopologyPart& provenance, TriangleMesh* mesh) {
  LATTICED_RETURN_IF_ERROR(CheckProvenance(source, topology, provenance));
  if (source.has_uvs()) CarryUvs(source, topology, provenance, mesh);
  if (source.face_groups.empty()) return absl::OkStatus();
  mesh->group_names = source.group_names;
  const size_t triangles_per_patch = static_cast<size_t>(topology.pattern().triangles_size()) / 3;
  mesh->triangle_groups.reserve(mesh->triangles.size());
  for (const uint32_t face : provenance.faces()) {
    mesh->triangle_groups.insert(mesh->triangle_groups.end(), triangles_per_patch,
                                 source.face_groups[face]);
  }
  return absl::OkStatus();
}

}  // namespace latticed::client
