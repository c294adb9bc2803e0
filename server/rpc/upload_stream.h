// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService.UploadMesh: header, parts, half-close, answer.
//
//   kHeader --header--> kParts --half-close--> kStoring (on env->workers) --> done
//   a header that does not come within --first-message-timeout ends the call
//   initial metadata goes out when the header is admitted; any refusal or cancellation ends the
//   call at once; what came is dropped
#ifndef LATTICED_SERVER_RPC_UPLOAD_STREAM_H_
#define LATTICED_SERVER_RPC_UPLOAD_STREAM_H_

#include <grpcpp/grpcpp.h>

#include "latticed/v1/mesh.pb.h"

namespace latticed {

struct Rpc;
struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerReadReactor<v1::UploadMeshRequest>* NewUploadStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, v1::Mesh* response);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPLOAD_STREAM_H_
