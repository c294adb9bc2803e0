// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/deformed_mesh.h"

#include <array>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/direct_ffd.h"
#include "core/mesh/vertex_values.h"

namespace latticed {
namespace {

using Jacobian = std::array<Vec3d, 3>;

Vec3f Carried(const Jacobian& jacobian, Vec3f rest) {
  const CarriedNormal normal = CarryNormal(jacobian.data(), ToDouble(rest));
  return normal.kappa <= kMaxNormalCondition ? ToFloat(normal.direction)
                                             : ToFloat(Unit(ToDouble(rest)));
}

// Replaces the normals by those of the deformed mesh.
absl::Status CarryNormals(std::span<const Jacobian> jacobians, StopPoll& poll, PolygonMesh& mesh) {
  const std::vector<Vec3f> rest = std::exchange(mesh.normals, {});
  VertexValues<Vec3f> normals(mesh.positions.size(), mesh.corner_count());
  for (size_t corner = 0; corner < mesh.corner_count(); ++corner) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    uint32_t& normal = mesh.corner_normals[corner];
    if (normal == PolygonMesh::kNoAttribute) continue;
    const uint32_t vertex = mesh.corner_vertices[corner];
    normal = normals.Add(vertex, Carried(jacobians[vertex], rest[normal]));
  }
  mesh.normals = std::move(normals).Take();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PolygonMesh> DeformedMesh(PolygonMesh mesh, const LatticeStructure& structure,
                                         std::span<const Vec3d> control_points, StopCheck stop) {
  StopPoll poll(stop);
  std::vector<Jacobian> jacobians;
  if (mesh.has_normals()) jacobians.reserve(mesh.positions.size());
  for (Vec3d& vertex : mesh.positions) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    const DeformedPoint deformed = EvaluateWorld(structure, control_points, vertex);
    vertex = deformed.position;
    if (mesh.has_normals()) jacobians.push_back(deformed.jacobian);
  }
  if (mesh.has_normals()) LATTICED_RETURN_IF_ERROR(CarryNormals(jacobians, poll, mesh));
  return mesh;
}

}  // namespace latticed
