// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads mesh files, by format. Each reader says what of its format it reads. Writers: core/mesh/write.
//
// Readers take untrusted bytes. They check each announced size against the size of the file before they allocate, and
// validate the mesh that they return. Errors: kInvalidArgument with reason MALFORMED_FILE names the line or byte.
#ifndef LATTICED_CORE_MESH_MESH_IO_H_
#define LATTICED_CORE_MESH_MESH_IO_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

class ReadingMemory;  // core/mesh/reading_memory.h

enum class MeshFormat { kObj, kPly, kStl, kGlb, kDraco, kUsd };

// By file extension, in any case. Errors: kInvalidArgument, which lists the known extensions.
[[nodiscard]] absl::StatusOr<MeshFormat> MeshFormatFromFileName(std::string_view file_name);
[[nodiscard]] std::string_view MeshFormatName(MeshFormat format);       // "OBJ", "PLY", …
[[nodiscard]] std::string_view MeshFormatExtension(MeshFormat format);  // "obj", "ply", …, "usda"

// kDraco is read by core/codec and refused here with kUnimplemented, as is kUsd, which is only written.
// `memory` grants what reading allocates; null grants everything.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadMesh(MeshFormat format, std::string_view bytes,
                                                   ReadingMemory* memory = nullptr);

// The same by one format.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadObj(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadPly(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadStl(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadGlb(std::string_view bytes,
                                                  ReadingMemory* memory = nullptr);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_MESH_IO_H_
