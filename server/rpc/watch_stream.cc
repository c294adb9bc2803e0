// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/watch_stream.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/rpc/update_stream.h"
#include "server/stores/scene_registry.h"

namespace latticed {

grpc::ServerWriteReactor<grpc::ByteBuffer>* NewWatchStream(const Rpc& rpc, ServerEnv* env,
                                                           grpc::CallbackServerContext* context,
                                                           const grpc::ByteBuffer* request) {
  return new UpdateStream(env, context, rpc, [env, request](CallInfo& call) {
    return ReadOpenRequest<v1::WatchRequest>(env, call, *request);
  });
}

absl::Status ControlWatch(ServerEnv* env, const v1::ControlWatchRequest& request,
                          v1::ControlWatchResponse* response) {
  if (request.watch_id().empty()) return error::InvalidField("watch_id", "is required");
  LATTICED_ASSIGN_OR_RETURN(auto watch, env->scenes->FindWatch(request.watch_id()));
  const Scene& scene = watch->scene();
  LATTICED_ASSIGN_OR_RETURN(const auto command, FromProto(request, scene));
  LATTICED_RETURN_IF_ERROR(watch->Control(command));
  response->set_head_revision(scene.State()->revision);
  return absl::OkStatus();
}

}  // namespace latticed
