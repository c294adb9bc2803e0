// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService.UploadMesh: header, parts, half-close, answer.
//
//   kHeader --header--> kParts --half-close--> kStoring (on a worker) --> done
//   A header that does not come within --first-message-timeout ends the call. Initial metadata is sent
//   when the header is admitted. Any refusal or cancellation ends the call at once and drops what came.
#ifndef LATTICED_SERVER_RPC_UPLOAD_STREAM_H_
#define LATTICED_SERVER_RPC_UPLOAD_STREAM_H_

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "latticed/v1/mesh.pb.h"
#include "server/stores/upload_store.h"

namespace latticed {

class ReplyRoom;
struct CallInfo;
struct Rpc;
struct ServerEnv;

// The end of an upload, by whichever rpc: verifies, parses and stores the mesh, and describes it in the
// reply. Takes seconds for large files: call it on a worker, once for each upload. The errors of
// MeshService.UploadMesh (mesh.proto), CheckCancelled's, and kResourceExhausted OUT_OF_MEMORY where the
// reply finds no room: then the mesh is not stored.
[[nodiscard]] absl::Status StoreUpload(ServerEnv& env, const CallInfo& call, Upload& upload,
                                       ReplyRoom& room, v1::Mesh& reply);

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerReadReactor<grpc::ByteBuffer>* NewUploadStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, grpc::ByteBuffer* reply);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPLOAD_STREAM_H_
