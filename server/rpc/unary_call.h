// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A call with one request and one reply:
//
//   BeginCall -> room for the request -> the handler on a worker -> room for the reply -> Finish
//
// A refused call changes nothing: a handler that changes something, and whose reply may be large, takes
// room for the reply itself, before it does.
//
// Threads  Run is gRPC's to call; the handler runs on a worker
#ifndef LATTICED_SERVER_RPC_UNARY_CALL_H_
#define LATTICED_SERVER_RPC_UNARY_CALL_H_

#include <functional>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "server/rpc/call.h"
#include "server/rpc/reply_room.h"

namespace latticed {

// What a handler has besides its request and its reply.
struct UnaryContext {
  ServerEnv& env;
  const CallInfo& call;
  ReplyRoom& room;
};

using UnaryWork = std::function<absl::Status(const UnaryContext& context)>;

// The response lives until the client has taken it; the request is freed once `work` has run. A call that
// was cancelled before its turn does not run. kResourceExhausted OUT_OF_MEMORY where too many requests wait,
// or where clients leave too many replies (ReplyRoom): then `work` has run, unless it took the room.
grpc::ServerUnaryReactor* RunUnary(ServerEnv* env, grpc::CallbackServerContext* context,
                                   const Rpc& rpc, const google::protobuf::Message& request,
                                   google::protobuf::Message* response, UnaryWork work);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UNARY_CALL_H_
