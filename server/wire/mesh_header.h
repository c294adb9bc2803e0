// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an upload announces (v1.MeshHeader), and its bytes read as announced.
//
// Errors   kInvalidArgument with the path of the field
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_MESH_HEADER_H_
#define LATTICED_SERVER_WIRE_MESH_HEADER_H_

#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/reading_memory.h"
#include "latticed/v1/mesh.pb.h"
#include "server/stores/mesh_store.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"

namespace latticed {

// A header that was checked: everything that can be refused before the bytes come is refused.
[[nodiscard]] absl::StatusOr<UploadHeader> FromProto(const v1::MeshHeader& header,
                                                     uint64_t max_mesh_bytes);
// The mesh in `bytes`, read in the format and layout of `described`. `memory` grants what that takes beside the bytes.
// MALFORMED_FILE; the errors of `memory`.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadUpload(const MeshDescription& described,
                                                     std::string_view bytes, ReadingMemory* memory);
// The header that would upload `mesh` again.
[[nodiscard]] v1::MeshHeader HeaderOf(const StoredMesh& mesh);
// Groups are left out of lists.
[[nodiscard]] v1::Mesh ToProto(const StoredMesh& mesh, const MeshUse& use, bool with_groups);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_MESH_HEADER_H_
