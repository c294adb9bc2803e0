// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An uploaded polygon mesh, as its file describes it: faces of any size, attributes per corner.
//
//   face f owns the corners  face_offsets[f] .. face_offsets[f + 1] - 1
//   corner c has the vertex  corner_vertices[c]   (always)
//            the normal      corner_normals[c]    (when normals is not empty)
//            and the uv      corner_uvs[c]        (when uvs is not empty)
//   vertex v has the weight  weights[v]           (when weights is not empty)
//   kNoAttribute marks a corner without normal or uv, in a file where others have one.
//
// Units    world units of the file; normals need not be unit length, and readers keep them as written
// Threads  plain data; immutable once uploaded
#ifndef LATTICED_CORE_MESH_POLYGON_MESH_H_
#define LATTICED_CORE_MESH_POLYGON_MESH_H_

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/bounds.h"
#include "core/base/vec.h"

namespace latticed {

struct PolygonMesh {
  static constexpr uint32_t kNoAttribute = std::numeric_limits<uint32_t>::max();

  std::vector<Vec3d> positions;
  std::vector<uint32_t> face_offsets{0};  // faces + 1 entries
  std::vector<uint32_t> corner_vertices;

  std::vector<Vec3f> normals;
  std::vector<uint32_t> corner_normals;
  std::vector<Vec2f> uvs;
  std::vector<uint32_t> corner_uvs;
  std::vector<float> weights;  // as written; a scene that takes them checks them

  std::vector<std::string> group_names;  // materials, OBJ groups, GLB primitives; may be empty
  std::vector<uint32_t> face_groups;     // per face, index into group_names; empty without groups

  size_t face_count() const { return face_offsets.size() - 1; }
  size_t corner_count() const { return corner_vertices.size(); }
  bool has_normals() const { return !normals.empty(); }
  bool has_uvs() const { return !uvs.empty(); }
  Bounds ComputeBounds() const;
  size_t MemoryBytes() const;
};

// Checks what every reader must guarantee: at least one face, faces of 3 corners or more, indices in range, finite
// numbers, sizes and coordinates within limits.h. Errors: kInvalidArgument naming the element.
[[nodiscard]] absl::Status Validate(const PolygonMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_POLYGON_MESH_H_
