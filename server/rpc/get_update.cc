// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/get_update.h"

#include "server/rpc/call.h"
#include "server/rpc/update_stream.h"

namespace latticed {

grpc::ServerWriteReactor<grpc::ByteBuffer>* NewGetUpdateStream(const Rpc& rpc, ServerEnv* env,
                                                               grpc::CallbackServerContext* context,
                                                               const grpc::ByteBuffer* request) {
  return new UpdateStream(env, context, rpc, [env, request](CallInfo& call) {
    return ReadOpenRequest<v1::GetUpdateRequest>(env, call, *request);
  });
}

}  // namespace latticed
