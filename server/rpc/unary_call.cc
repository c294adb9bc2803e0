// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/unary_call.h"

#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "server/rpc/server_env.h"
#include "server/wire/grpc_status.h"

namespace latticed {
namespace {

using google::protobuf::Message;

grpc::ServerUnaryReactor* Refuse(grpc::CallbackServerContext* context, const grpc::Status& status) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  UnaryCall(ServerEnv& env, CallInfo call, MemoryReservation room, const Message& request,
            Message* response)
      : env_(env),
        call_(std::move(call)),
        request_(request),
        response_(response),
        request_room_(std::move(room)),
        reply_room_(env) {}

  void Run(const UnaryWork& work) {
    absl::Status result = CheckCancelled(*call_.context);
    if (result.ok()) {
      result = CatchBadAlloc("the request", [&] { return work({env_, call_, reply_room_}); });
    }
    FreeMessage(request_);
    request_room_.Release();
    if (result.ok()) result = reply_room_.Hold(ReplyBytes(*response_));
    if (!result.ok()) FreeMessage(*response_);
    const grpc::Status status = ToGrpcStatus(result);
    LogFinished(call_, status);
    Finish(status);
  }

  void OnDone() override { delete this; }

 private:
  ServerEnv& env_;
  const CallInfo call_;
  const Message& request_;
  Message* const response_;
  MemoryReservation request_room_;
  ReplyRoom reply_room_;
};

}  // namespace

grpc::ServerUnaryReactor* RunUnary(ServerEnv* env, grpc::CallbackServerContext* context,
                                   const Rpc& rpc, const Message& request, Message* response,
                                   UnaryWork work) {
  absl::StatusOr<CallInfo> call = BeginCall(*env, context, rpc);
  if (!call.ok()) return Refuse(context, ToGrpcStatus(call.status()));
  auto room = AdmitRequest(*env, request);
  if (!room.ok()) {
    const grpc::Status status = ToGrpcStatus(room.status());
    LogFinished(*call, status);
    return Refuse(context, status);
  }
  auto* unary = new UnaryCall(*env, *std::move(call), *std::move(room), request, response);
  env->workers.Post([unary, work = std::move(work)] { unary->Run(work); });
  return unary;
}

}  // namespace latticed
