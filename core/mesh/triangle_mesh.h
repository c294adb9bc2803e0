// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A tessellated surface as a client assembles it: one record per vertex, in world coordinates.
#ifndef LATTICED_CORE_MESH_TRIANGLE_MESH_H_
#define LATTICED_CORE_MESH_TRIANGLE_MESH_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh_units.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

struct TriangleMesh {
  std::vector<Vec3d> positions;
  std::vector<Vec3f> normals;  // empty, or one per position
  std::vector<Vec2f> uvs;      // empty, or one per position
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<std::string> group_names;   // may be empty
  std::vector<uint32_t> triangle_groups;  // empty, or one per triangle
  MeshUnits units;
};

// The same as polygons, to be written: vertices at the same place, bit for bit, become one, with normals and texture
// coordinates as in vertex_values.h; slivers go (short_edges.h). Units are no part of it.
[[nodiscard]] PolygonMesh Welded(const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_TRIANGLE_MESH_H_
