// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/deformed_mesh.h"

#include <array>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/mesh/vertex_values.h"

namespace latticed {
namespace {

using Jacobian = std::array<Vec3d, 3>;

Vec3f Carried(const Jacobian& jacobian, Vec3f rest) {
  const CarriedNormal normal = CarryNormal(jacobian.data(), ToDouble(rest));
  return normal.kappa <= kMaxNormalCondition ? ToFloat(normal.direction)
                                             : ToFloat(Unit(ToDouble(rest)));
}

// What carries the normals at a vertex. With weights, a corner adds its gradient.
struct Carrier {
  Jacobian jacobian;
  Vec3d rest, offset;
};

// The gradient of the weight at a corner, between its two neighbours in the face.
Vec3d GradientAt(const PolygonMesh& mesh, std::span<const Carrier> carriers,
                 std::span<const float> weights, size_t face, size_t corner) {
  const size_t first = mesh.face_offsets[face], count = mesh.face_offsets[face + 1] - first;
  std::array<Vec3d, 3> corners;
  std::array<double, 3> values;
  for (size_t k = 0; k < 3; ++k) {
    const uint32_t vertex = mesh.corner_vertices[first + (corner - first + count - 1 + k) % count];
    corners[k] = carriers[vertex].rest;
    values[k] = weights[vertex];
  }
  return WeightGradient(corners, values);
}

// Replaces the normals by those of the deformed mesh.
absl::Status CarryNormals(std::span<const Carrier> carriers, std::span<const float> weights,
                          StopPoll& poll, PolygonMesh& mesh) {
  const std::vector<Vec3f> rest = std::exchange(mesh.normals, {});
  VertexValues<Vec3f> normals(mesh.positions.size(), mesh.corner_count());
  size_t face = 0;
  for (size_t corner = 0; corner < mesh.corner_count(); ++corner) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    while (corner >= mesh.face_offsets[face + 1]) ++face;
    uint32_t& normal = mesh.corner_normals[corner];
    if (normal == PolygonMesh::kNoAttribute) continue;
    const uint32_t vertex = mesh.corner_vertices[corner];
    Jacobian jacobian = carriers[vertex].jacobian;
    if (!weights.empty()) {
      const Vec3d gradient = GradientAt(mesh, carriers, weights, face, corner);
      for (int axis = 0; axis < 3; ++axis) {
        jacobian[static_cast<size_t>(axis)] += gradient[axis] * carriers[vertex].offset;
      }
    }
    normal = normals.Add(vertex, Carried(jacobian, rest[normal]));
  }
  mesh.normals = std::move(normals).Take();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PolygonMesh> DeformedMesh(PolygonMesh mesh,
                                         absl::FunctionRef<DeformedPoint(Vec3d)> deform,
                                         StopCheck stop, std::span<const float> weights) {
  StopPoll poll(stop);
  std::vector<Carrier> carriers;
  if (mesh.has_normals()) carriers.reserve(mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    const Vec3d rest = mesh.positions[v];
    DeformedPoint deformed = deform(rest);
    const Vec3d offset = deformed.position - rest;
    if (!weights.empty()) Weigh(rest, weights[v], {}, deformed.position, deformed.jacobian);
    mesh.positions[v] = deformed.position;
    if (mesh.has_normals()) carriers.push_back({deformed.jacobian, rest, offset});
  }
  if (mesh.has_normals()) LATTICED_RETURN_IF_ERROR(CarryNormals(carriers, weights, poll, mesh));
  return mesh;
}

}  // namespace latticed
