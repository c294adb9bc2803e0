// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stanford PLY: ascii, binary little endian, binary big endian.
//
// Read are, of the element `vertex`: x y z, nx ny nz, and a pair s t, u v or texture_u texture_v;
// of `face`: the list vertex_indices or vertex_index; of `tristrips`: the list vertex_indices,
// strips ended by -1, whose triangles with a repeated vertex join strips and are left out. Other
// elements and properties, lists too, are passed over. Texture coordinates have their origin below
// left.
//
// Errors   reading: kInvalidArgument, reason MALFORMED_FILE, naming line (header, ascii) or byte
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_PLY_IO_H_
#define LATTICED_CORE_MESH_PLY_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<PolygonMesh> ReadPly(std::string_view bytes);

// Binary little endian: float x y z [nx ny nz] [s t], then `list uchar int vertex_indices`. Groups
// have no place in PLY.
[[nodiscard]] std::string WritePly(const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_PLY_IO_H_
