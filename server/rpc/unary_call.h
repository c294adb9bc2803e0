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
// A refused call changes nothing: work that changes something, and whose reply may be large, takes room
// for that itself, before it does.
//
// Threads  RunUnary is gRPC's to call; `work` runs on a worker
#ifndef LATTICED_SERVER_RPC_UNARY_CALL_H_
#define LATTICED_SERVER_RPC_UNARY_CALL_H_

#include <functional>
#include <string_view>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "server/rpc/call.h"
#include "server/rpc/reply_room.h"

namespace latticed {

// What a call does, its reply included, for which `room` may be taken.
using UnaryWork = std::function<absl::Status(const CallInfo& call, ReplyRoom& room)>;

// The response lives until the client has taken it, what the request holds only as long as `work`
// runs. A call that was cancelled before its turn does not run. kResourceExhausted OUT_OF_MEMORY
// where too many requests wait, or where clients leave too many replies (ReplyRoom): then `work` has
// run, unless it took the room.
grpc::ServerUnaryReactor* RunUnary(ServerEnv* env, grpc::CallbackServerContext* context,
                                   std::string_view rpc, const google::protobuf::Message& request,
                                   google::protobuf::Message* response, UnaryWork work);

// For work that changes nothing, or whose reply is always small.
inline grpc::ServerUnaryReactor* RunUnary(ServerEnv* env, grpc::CallbackServerContext* context,
                                          std::string_view rpc,
                                          const google::protobuf::Message& request,
                                          google::protobuf::Message* response,
                                          std::function<absl::Status(const CallInfo&)> work) {
  return RunUnary(
      env, context, rpc, request, response,
      [work = std::move(work)](const CallInfo& call, ReplyRoom&) { return work(call); });
}

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UNARY_CALL_H_
