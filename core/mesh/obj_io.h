// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Wavefront OBJ: v, vt, vn, f, g, o, usemtl; everything else is skipped.
//
// Faces may have any size, and any of the forms v, v/vt, v//vn, v/vt/vn; indices may be negative
// and may point forward. A face's group is its material (usemtl), else its group (g), else its
// object (o). Line ends LF, CRLF or CR; lines go on after a backslash. Texture coordinates have
// their origin below left.
//
// Errors   reading: kInvalidArgument, reason MALFORMED_FILE, naming the line
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_OBJ_IO_H_
#define LATTICED_CORE_MESH_OBJ_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<PolygonMesh> ReadObj(std::string_view bytes);

// Numbers are the shortest decimals that read back to the same bits.
[[nodiscard]] std::string WriteObj(const TriangleMesh& mesh);
[[nodiscard]] std::string WriteObj(const PolygonMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_OBJ_IO_H_
