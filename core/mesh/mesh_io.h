// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Mesh files in and out, by format. The work is in obj_io, ply_io, stl_io and glb_io.
//
// Readers take untrusted bytes: they check every announced size against the bytes that are there
// before they allocate, and validate what they return. kInvalidArgument with reason MALFORMED_FILE
// names the line or byte. Writers cannot fail but for memory.
#ifndef LATTICED_CORE_MESH_MESH_IO_H_
#define LATTICED_CORE_MESH_MESH_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

enum class MeshFormat { kObj, kPly, kStl, kGlb, kDraco };

// By file extension, any case; kInvalidArgument lists what is known.
[[nodiscard]] absl::StatusOr<MeshFormat> MeshFormatFromFileName(std::string_view file_name);
[[nodiscard]] std::string_view MeshFormatName(MeshFormat format);       // "OBJ", "PLY", …
[[nodiscard]] std::string_view MeshFormatExtension(MeshFormat format);  // "obj", "ply", …, "drc"

// kDraco is read by core/codec and refused here with kUnimplemented.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadMesh(MeshFormat format, std::string_view bytes);

// OBJ, PLY (binary little endian: float x y z nx ny nz s t as present, uchar int faces), STL
// (binary), GLB (float32 relative to a node translation). Known units are a comment in the first
// three, and a root node in GLB; groups are in OBJ and GLB alone.
[[nodiscard]] absl::StatusOr<std::string> WriteMesh(MeshFormat format, const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_MESH_IO_H_
