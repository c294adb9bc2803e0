// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// libdraco's decoders of meshes, which ask for memory before they allocate it: once for what the stream's header
// announces, and again for its attributes, which are announced behind the faces.
//
// Not asked for: tables of entropy codes, one at a time. libdraco takes up to 4 MiB for any, and 768 bytes per byte of
// the stream for one that announces more symbols than 18 bits can number, which no encoder writes. Nor the
// orientations of predicted UVs: 256 MiB for each attribute that announces too many.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE; those of `memory`
// Throws   std::bad_alloc, std::length_error: corrupt tables
// Threads  pure function
#ifndef LATTICED_CORE_CODEC_DRACO_MESH_DECODER_H_
#define LATTICED_CORE_CODEC_DRACO_MESH_DECODER_H_

#include <memory>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/codec/draco_announcement.h"
#include "draco/mesh/mesh.h"

namespace latticed {

class ReadingMemory;  // core/mesh/reading_memory.h

// `announcement` is that of `bytes`, and passed CheckDracoSize. `memory` may be null: everything is granted.
[[nodiscard]] absl::StatusOr<std::unique_ptr<draco::Mesh>> DecodeDracoMesh(
    const DracoAnnouncement& announcement, std::string_view bytes, ReadingMemory* memory);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_MESH_DECODER_H_
