// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A triangle mesh ready for export: one record per vertex, in world coordinates.
#ifndef LATTICED_CORE_MESH_TRIANGLE_MESH_H_
#define LATTICED_CORE_MESH_TRIANGLE_MESH_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/mesh/mesh_units.h"

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

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_TRIANGLE_MESH_H_
