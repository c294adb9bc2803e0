// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A call with one request and one reply:
//
//   return RunUnary(env_, context, "SceneService/GetScene", *request, response,
//                   [=](const CallInfo& call) -> absl::Status { …fill *response… });
//
//   BeginCall -> room for the request -> `work` on a worker -> room for the reply -> Finish
//
// Threads  RunUnary is gRPC's to call; `work` runs on a worker
#ifndef LATTICED_SERVER_RPC_UNARY_CALL_H_
#define LATTICED_SERVER_RPC_UNARY_CALL_H_

#include <functional>
#include <string_view>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "server/rpc/call.h"

namespace latticed {

// The response lives until the client has taken it, what the request holds only as long as `work`
// runs. A call that was cancelled before its turn does not run. kResourceExhausted OUT_OF_MEMORY
// where too many requests wait, or where clients leave too many replies (ReplyRoom): then `work` has
// run.
grpc::ServerUnaryReactor* RunUnary(ServerEnv* env, grpc::CallbackServerContext* context,
                                   std::string_view rpc, const google::protobuf::Message& request,
                                   google::protobuf::Message* response,
                                   std::function<absl::Status(const CallInfo&)> work);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UNARY_CALL_H_
