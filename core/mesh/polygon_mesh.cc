// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/polygon_mesh.h"

#include <algorithm>
#include <cmath>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

template <typename T>
size_t BytesOf(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

absl::Status Invalid(std::string message) { return absl::InvalidArgumentError(message); }

absl::Status CheckSizes(const PolygonMesh& mesh) {
  if (mesh.face_offsets.empty() || mesh.face_offsets.front() != 0 ||
      mesh.face_offsets.back() != mesh.corner_count()) {
    return Invalid("face_offsets do not run from 0 to the number of corners");
  }
  if (mesh.face_count() == 0) return Invalid("the mesh has no faces");
  if (mesh.positions.size() > limits::kMaxMeshVertices) {
    return Invalid(fmt::format("{} vertices; at most {} are allowed", mesh.positions.size(),
                               limits::kMaxMeshVertices));
  }
  if (mesh.face_count() > limits::kMaxMeshFaces) {
    return Invalid(
        fmt::format("{} faces; at most {} are allowed", mesh.face_count(), limits::kMaxMeshFaces));
  }
  const auto check = [](std::string_view what, size_t got, size_t wanted) {
    if (got == wanted) return absl::OkStatus();
    return Invalid(fmt::format("{} has {} entries instead of {}", what, got, wanted));
  };
  const size_t corners = mesh.corner_count();
  LATTICED_RETURN_IF_ERROR(
      check("weights", mesh.weights.size(), mesh.weights.empty() ? 0 : mesh.positions.size()));
  LATTICED_RETURN_IF_ERROR(
      check("corner_normals", mesh.corner_normals.size(), mesh.has_normals() ? corners : 0));
  LATTICED_RETURN_IF_ERROR(
      check("corner_uvs", mesh.corner_uvs.size(), mesh.has_uvs() ? corners : 0));
  return check("face_groups", mesh.face_groups.size(),
               mesh.group_names.empty() ? 0 : mesh.face_count());
}

absl::Status CheckNumbers(const PolygonMesh& mesh) {
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    if (!IsFinite(mesh.positions[i])) {
      return Invalid(fmt::format("vertex {} is not finite", i));
    }
    const Vec3d p = mesh.positions[i];
    if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > limits::kMaxCoordinate) {
      return Invalid(
          fmt::format("vertex {} is farther than {:g} from the origin", i, limits::kMaxCoordinate));
    }
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    if (!IsFinite(ToDouble(mesh.normals[i]))) {
      return Invalid(fmt::format("normal {} is not finite", i));
    }
  }
  for (size_t i = 0; i < mesh.uvs.size(); ++i) {
    if (!std::isfinite(mesh.uvs[i].x) || !std::isfinite(mesh.uvs[i].y)) {
      return Invalid(fmt::format("texture coordinate {} is not finite", i));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckIndices(const std::vector<uint32_t>& indices, size_t count, bool may_be_absent,
                          std::string_view what) {
  for (size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < count || (may_be_absent && indices[i] == PolygonMesh::kNoAttribute)) continue;
    return Invalid(
        fmt::format("corner {} has the {} index {}; the mesh has {}", i, what, indices[i], count));
  }
  return absl::OkStatus();
}

absl::Status CheckFaces(const PolygonMesh& mesh) {
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_offsets[f + 1] < mesh.face_offsets[f]) {
      return Invalid(fmt::format("face_offsets decrease at face {}", f));
    }
    const uint32_t corners = mesh.face_offsets[f + 1] - mesh.face_offsets[f];
    if (corners < 3)
      return Invalid(fmt::format("face {} has {} corners; 3 are needed", f, corners));
    if (corners > limits::kMaxFaceCorners) {
      return Invalid(fmt::format("face {} has {} corners; at most {} are allowed", f, corners,
                                 limits::kMaxFaceCorners));
    }
  }
  for (size_t f = 0; f < mesh.face_groups.size(); ++f) {
    if (mesh.face_groups[f] < mesh.group_names.size()) continue;
    return Invalid(fmt::format("face {} has the group index {}; the mesh has {}", f,
                               mesh.face_groups[f], mesh.group_names.size()));
  }
  return absl::OkStatus();
}

}  // namespace

Bounds PolygonMesh::ComputeBounds() const {
  Bounds bounds;
  for (const uint32_t vertex : corner_vertices) bounds.Extend(positions[vertex]);
  return bounds;
}

size_t PolygonMesh::MemoryBytes() const {
  size_t bytes = sizeof(*this) + BytesOf(positions) + BytesOf(face_offsets) +
                 BytesOf(corner_vertices) + BytesOf(normals) + BytesOf(corner_normals) +
                 BytesOf(uvs) + BytesOf(corner_uvs) + BytesOf(weights) + BytesOf(group_names) +
                 BytesOf(face_groups);
  for (const std::string& name : group_names) bytes += name.capacity();
  return bytes;
}

absl::Status Validate(const PolygonMesh& mesh) {
  LATTICED_RETURN_IF_ERROR(CheckSizes(mesh));
  LATTICED_RETURN_IF_ERROR(CheckNumbers(mesh));
  LATTICED_RETURN_IF_ERROR(CheckFaces(mesh));
  LATTICED_RETURN_IF_ERROR(
      CheckIndices(mesh.corner_vertices, mesh.positions.size(), false, "vertex"));
  LATTICED_RETURN_IF_ERROR(CheckIndices(mesh.corner_normals, mesh.normals.size(), true, "normal"));
  return CheckIndices(mesh.corner_uvs, mesh.uvs.size(), true, "texture coordinate");
}

}  // namespace latticed
