// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.GetUpdate: one full update at the newest revision, then the end.
#ifndef LATTICED_SERVER_RPC_GET_UPDATE_H_
#define LATTICED_SERVER_RPC_GET_UPDATE_H_

#include <grpcpp/grpcpp.h>

namespace latticed {

struct Rpc;
struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerWriteReactor<grpc::ByteBuffer>* NewGetUpdateStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
    const grpc::ByteBuffer* request);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_GET_UPDATE_H_
