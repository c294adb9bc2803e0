// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/original_mesh.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/deformed_mesh.h"
#include "core/mesh/triangulated.h"

namespace latticed {
namespace {

// The mesh at rest, with the normals that the scene is shaded with, one for each corner, or with none.
PolygonMesh AtRest(const DeformPlan& plan, NormalMode normals) {
  const PolygonMesh& source = *plan.mesh;
  PolygonMesh mesh;
  mesh.positions = source.positions;
  mesh.face_offsets = source.face_offsets;
  mesh.corner_vertices = source.corner_vertices;
  mesh.uvs = source.uvs;
  mesh.corner_uvs = source.corner_uvs;
  mesh.group_names = source.group_names;
  mesh.face_groups = source.face_groups;
  if (normals != NormalMode::kSmooth) return mesh;
  mesh.normals = plan.vertex_normals;
  mesh.corner_normals.resize(mesh.corner_count());
  std::iota(mesh.corner_normals.begin(), mesh.corner_normals.end(), 0u);
  return mesh;
}

}  // namespace

absl::StatusOr<PolygonMesh> OriginalMesh(const SceneState& state, NormalMode normals,
                                         bool keeps_polygons, StopCheck stop) {
  PolygonMesh mesh = AtRest(*state.plan, normals);
  if (!keeps_polygons && !IsTriangular(mesh)) {
    LATTICED_ASSIGN_OR_RETURN(mesh, Triangulated(mesh, stop));
  }
  const auto deform = [&](Vec3d world) {
    return EvaluateWorld(*state.plan, *state.control_points, world);
  };
  const VertexWeights& weights = state.plan->mesh_weights;
  return DeformedMesh(std::move(mesh), deform, stop,
                      weights == nullptr ? std::span<const float>() : *weights);
}

SurfaceMemory MemoryOfOriginalMesh(const DeformPlan& plan, NormalMode normals,
                                   bool keeps_polygons) {
  const PolygonMesh& mesh = *plan.mesh;
  const bool smooth = normals == NormalMode::kSmooth;
  WrittenSizes sizes = WrittenSizesOf(mesh);
  if (!keeps_polygons) {
    sizes.faces = mesh.corner_count() - 2 * mesh.face_count();
    sizes.corners = 3 * sizes.faces;
  }
  sizes.normals = smooth ? sizes.corners : 0;
  sizes.records = smooth || mesh.has_uvs() ? sizes.corners : sizes.positions;
  // The mesh at rest beside its triangles; Jacobians, normals at rest, and lists of normals by vertex.
  WrittenSizes at_rest = WrittenSizesOf(mesh);
  at_rest.normals = smooth ? mesh.corner_count() : 0;
  const uint64_t carrying =
      smooth ? sizes.positions * (sizeof(std::array<Vec3d, 3>) + sizeof(uint32_t)) +
                   mesh.corner_count() * sizeof(Vec3f) + sizes.corners * sizeof(uint32_t)
             : 0;
  // Dividing a face: its corners and triangles, and a tree of the corners.
  constexpr uint64_t kBytesPerCorner = 192;
  uint32_t largest = 0;
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    largest = std::max(largest, mesh.face_offsets[f + 1] - mesh.face_offsets[f]);
  }
  const uint64_t dividing = keeps_polygons ? 0 : largest * kBytesPerCorner;
  return {.sizes = sizes, .working_bytes = MeshBytes(at_rest) + carrying + dividing};
}

}  // namespace latticed
