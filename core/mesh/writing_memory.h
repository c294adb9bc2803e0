// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The most memory that writing a TriangleMesh takes, file included, before there is a mesh.
//
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_WRITING_MEMORY_H_
#define LATTICED_CORE_MESH_WRITING_MEMORY_H_

#include <cstdint>

#include "core/mesh/mesh_io.h"

namespace latticed {

struct WrittenSizes {
  uint64_t points = 0, triangles = 0;
  bool has_normals = false, has_uvs = false;
  uint64_t groups = 0;
  uint64_t name_bytes = 0;  // of all groups
  // OBJ names the group wherever the next triangle has another: how often, and the bytes of these names.
  uint64_t group_lines = 0, group_line_bytes = 0;
};

// What WriteMesh allocates at a time, or WriteDracoMesh, beside the mesh.
[[nodiscard]] uint64_t MostWritingBytes(MeshFormat format, const WrittenSizes& sizes);

// The longest OBJ file of these sizes.
[[nodiscard]] uint64_t MostObjBytes(const WrittenSizes& sizes);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_WRITING_MEMORY_H_
