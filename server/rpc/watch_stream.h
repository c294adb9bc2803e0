// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Watch, and ControlWatch that steers it: Deform without edits, for clients that
// cannot stream up.
#ifndef LATTICED_SERVER_RPC_WATCH_STREAM_H_
#define LATTICED_SERVER_RPC_WATCH_STREAM_H_

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "latticed/v1/scene.pb.h"

namespace latticed {

struct Rpc;
struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerWriteReactor<grpc::ByteBuffer>* NewWatchStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
    const grpc::ByteBuffer* request);

// The work of the unary ControlWatch. kNotFound for a watch that has ended, kInvalidArgument for a
// field, kResourceExhausted for one view too many.
[[nodiscard]] absl::Status ControlWatch(ServerEnv* env, const v1::ControlWatchRequest& request,
                                        v1::ControlWatchResponse* response);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_WATCH_STREAM_H_
