// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService.Deform: edits, view control and watching in one bidirectional stream.
//
//   new DeformStream -> the first message, within --first-message-timeout, opens the watch
//   (scene_stream.h) -> reads and writes run concurrently -> half-close, cancellation, goaway or a fatal
//   status ends it
#ifndef LATTICED_SERVER_RPC_DEFORM_STREAM_H_
#define LATTICED_SERVER_RPC_DEFORM_STREAM_H_

#include <grpcpp/grpcpp.h>

namespace latticed {

struct Rpc;
struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* NewDeformStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_DEFORM_STREAM_H_
