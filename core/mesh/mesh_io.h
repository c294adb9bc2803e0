// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads and writes mesh files, by format. Each reader says what of its format it reads.
//
// Readers take untrusted bytes. They check each announced size against the size of the file before they allocate, and
// validate the mesh that they return. Errors: kInvalidArgument with reason MALFORMED_FILE names the line or byte.
// Writers fail only for memory, except as noted.
#ifndef LATTICED_CORE_MESH_MESH_IO_H_
#define LATTICED_CORE_MESH_MESH_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed {

class ReadingMemory;  // core/mesh/reading_memory.h

enum class MeshFormat { kObj, kPly, kStl, kGlb, kDraco };

// By file extension, in any case. Errors: kInvalidArgument, which lists the known extensions.
[[nodiscard]] absl::StatusOr<MeshFormat> MeshFormatFromFileName(std::string_view file_name);
[[nodiscard]] std::string_view MeshFormatName(MeshFormat format);       // "OBJ", "PLY", …
[[nodiscard]] std::string_view MeshFormatExtension(MeshFormat format);  // "obj", "ply", …, "drc"

// kDraco is read by core/codec and refused here with kUnimplemented.
// `memory` grants what reading allocates; null grants everything.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadMesh(MeshFormat format, std::string_view bytes,
                                                   ReadingMemory* memory = nullptr);

// OBJ, PLY (binary little endian: float x y z nx ny nz s t as present, uchar int faces), STL (binary), GLB (float32
// relative to a node translation). Known units are written as a comment in the first three, and as a root node in GLB.
// Only OBJ and GLB keep groups.
[[nodiscard]] absl::StatusOr<std::string> WriteMesh(MeshFormat format, const TriangleMesh& mesh);

// The same by one format.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadObj(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadPly(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadStl(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadGlb(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
// Numbers are the shortest decimals that read back to the same bits.
[[nodiscard]] std::string WriteObj(const TriangleMesh& mesh);
[[nodiscard]] std::string WriteObj(const PolygonMesh& mesh);
// Binary little endian: float x y z [nx ny nz] [s t], then `list uchar int vertex_indices`. Groups are left out.
[[nodiscard]] std::string WritePly(const TriangleMesh& mesh);
// Binary. Positions become float, so vertices far from the origin may coincide.
[[nodiscard]] std::string WriteStl(const TriangleMesh& mesh);
// One mesh on one node. Positions are float32 about the centre of the bounds, which is the node's translation: a mesh
// far from the origin keeps its precision. Every group is a primitive with a material of its name. With known units,
// the node is the child of a root that rotates and scales to glTF's own (metres, +y up), and asset.extras names the
// units as upAxis and metersPerUnit. kResourceExhausted above the 4 GiB of a GLB.
[[nodiscard]] absl::StatusOr<std::string> WriteGlb(const TriangleMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_MESH_IO_H_
