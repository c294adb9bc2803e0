// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes from the bytes of their uploads, as they come from a client or from the store.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_STORED_MESH_H_
#define LATTICED_SERVER_WIRE_STORED_MESH_H_

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "latticed/v1/mesh.pb.h"
#include "server/engine/memory/memory_budget.h"
#include "server/stores/mesh_store.h"
#include "server/stores/upload_store.h"

namespace latticed {

// Reads the mesh from its bytes. `reservation` grows by what reading takes. The creation time is still to be set.
// kInvalidArgument, reasons HASH_MISMATCH and MALFORMED_FILE; kResourceExhausted; what `stop` says.
[[nodiscard]] absl::StatusOr<StoredMesh> ReadStoredMesh(UploadHeader header,
                                                        std::shared_ptr<const std::string> bytes,
                                                        MemoryReservation& reservation,
                                                        StopCheck stop);

// What a store keeps of the mesh beside its bytes; what lists show of that, which headers of older servers lack; and the
// mesh from both. kDataLoss; the errors of ReadStoredMesh.
[[nodiscard]] std::string StoredHeaderOf(const StoredMesh& mesh);
[[nodiscard]] absl::StatusOr<v1::Mesh> ListedFromStored(std::string_view header);
[[nodiscard]] absl::StatusOr<StoredMesh> MeshFromStored(std::string_view header,
                                                        std::shared_ptr<const std::string> bytes,
                                                        MemoryReservation& reservation);

// The header of the same mesh, which belongs to `tenant`. kDataLoss.
[[nodiscard]] absl::StatusOr<std::string> HeaderForTenant(std::string_view header,
                                                          const std::string& tenant);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_STORED_MESH_H_
