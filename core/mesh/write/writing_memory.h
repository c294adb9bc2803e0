// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The most memory that writing a mesh takes, file included.
//
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_WRITE_WRITING_MEMORY_H_
#define LATTICED_CORE_MESH_WRITE_WRITING_MEMORY_H_

#include <cstdint>
#include <string_view>

#include "core/mesh/mesh_io.h"

namespace latticed {

struct WrittenSizes {
  uint64_t positions = 0, normals = 0, uvs = 0;
  uint64_t records = 0;  // at most (vertex_records.h)
  uint64_t corners = 0, faces = 0;
  uint64_t groups = 0;
  uint64_t name_bytes = 0;  // of all groups
  // OBJ names the group wherever the next face has another: how often, and the bytes of these names.
  uint64_t group_lines = 0, group_line_bytes = 0;
};

[[nodiscard]] WrittenSizes WrittenSizesOf(const PolygonMesh& mesh);

// Of the arrays of a PolygonMesh.
[[nodiscard]] uint64_t MeshBytes(const WrittenSizes& sizes);

// What WriteMesh allocates at a time, or WriteDracoMesh, beside the mesh. Faces are triangles where the format has no
// others. `source`: FileExtras::source, if it is of this format.
[[nodiscard]] uint64_t MostWritingBytes(MeshFormat format, const WrittenSizes& sizes,
                                        std::string_view source = {});

// Of the lines of an uploaded OBJ that an OBJ keeps.
inline constexpr uint64_t kMostLibraryBytes = uint64_t{64} << 10;

// The longest OBJ and USD files of these sizes.
[[nodiscard]] uint64_t MostObjBytes(const WrittenSizes& sizes);
[[nodiscard]] uint64_t MostUsdBytes(const WrittenSizes& sizes);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_WRITE_WRITING_MEMORY_H_
