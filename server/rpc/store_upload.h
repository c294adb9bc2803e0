// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The end of an upload, by whichever rpc: verifies, parses and stores the mesh, and describes it in the
// reply.
//
// Errors   those of MeshService.UploadMesh (mesh.proto); kCancelled; kResourceExhausted OUT_OF_MEMORY where
//          the reply finds no room: then the mesh is not stored
// Threads  safe; seconds for large files, so not on a gRPC thread
#ifndef LATTICED_SERVER_RPC_STORE_UPLOAD_H_
#define LATTICED_SERVER_RPC_STORE_UPLOAD_H_

#include <functional>

#include "absl/status/status.h"
#include "latticed/v1/mesh.pb.h"
#include "server/rpc/reply_room.h"
#include "server/stores/upload_store.h"

namespace latticed {

struct ServerEnv;

// Call once for each upload. `cancelled` is asked between the steps.
[[nodiscard]] absl::Status StoreUpload(ServerEnv& env, Upload& upload,
                                       const std::function<bool()>& cancelled, ReplyRoom& room,
                                       v1::Mesh& reply);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_STORE_UPLOAD_H_
