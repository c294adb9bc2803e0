// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/get_update.h"

#include "server/call.h"
#include "server/server_env.h"
#include "server/update_stream.h"

namespace latticed {
namespace {

absl::StatusOr<OpenRequest> OpenUpdate(ServerEnv* env, CallInfo& call,
                                       const grpc::ByteBuffer& bytes) {
  v1::GetUpdateRequest request;
  if (auto s = ParseMessage(bytes, &request); !s.ok()) return s;
  call.scene = request.scene();
  return FromProto(env, *call.context, request);
}

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* NewGetUpdateStream(ServerEnv* env,
                                                               grpc::CallbackServerContext* context,
                                                               const grpc::ByteBuffer* request) {
  return new UpdateStream(env, context, "SceneService/GetUpdate", [env, request](CallInfo& call) {
    return OpenUpdate(env, call, *request);
  });
}

}  // namespace latticed
