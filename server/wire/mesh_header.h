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
#include "latticed/v1/mesh.pb.h"
#include "server/stores/mesh_store.h"
#include "server/stores/scene_registry.h"

namespace latticed {

// Everything that can be refused before the bytes come.
[[nodiscard]] absl::Status CheckHeader(const v1::MeshHeader& header, uint64_t max_mesh_bytes);
// Reason HASH_MISMATCH where the header announced another digest than `sha256_hex`.
[[nodiscard]] absl::Status CheckSha256(const v1::MeshHeader& header, std::string_view sha256_hex);
// The mesh in `bytes`; MALFORMED_FILE. The header has been checked.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadUpload(const v1::MeshHeader& header,
                                                     std::string_view bytes);

// Name, format, layout, labels and units of a checked header; the rest is left for the caller.
[[nodiscard]] StoredMesh Describe(const v1::MeshHeader& header);
// The header that would upload `mesh` again.
[[nodiscard]] v1::MeshHeader HeaderOf(const StoredMesh& mesh);
// Groups are left out of lists.
[[nodiscard]] v1::Mesh ToProto(const StoredMesh& mesh, const MeshUse& use, bool with_groups);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_MESH_HEADER_H_
