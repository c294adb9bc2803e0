// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server stream whose messages are pulled one by one: GetTopology, Export, DownloadMesh.
//
//   new PartStream -> open() on a worker -> next(), write, next(), write, … -> Finish
//
// One message is out at a time, so that a slow client holds one part and no more, which has its
// room (ReplyRoom). What the request holds is kept until open() has run.
//
// Errors   those of open and next; kResourceExhausted OUT_OF_MEMORY, also where too many requests wait
// Threads  open and next run one after the other; `cancelled` may be asked from any thread
#ifndef LATTICED_SERVER_RPC_PART_STREAM_H_
#define LATTICED_SERVER_RPC_PART_STREAM_H_

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/status/statusor.h"
#include "core/base/catch_bad_alloc.h"
#include "server/rpc/call.h"
#include "server/rpc/reply_room.h"
#include "server/rpc/server_env.h"
#include "server/wire/grpc_status.h"

namespace latticed {

// The next message, nullopt after the last.
template <typename Message>
using NextPart = std::function<absl::StatusOr<std::optional<Message>>()>;

// What opens a stream has this besides its request.
struct PartContext {
  ServerEnv& env;
  const grpc::CallbackServerContext& grpc;
  const std::function<bool()>& cancelled;  // whether the client has gone, for long work to ask
};

template <typename Message>
class PartStream final : public grpc::ServerWriteReactor<Message> {
 public:
  using Next = NextPart<Message>;
  // The long work before the first message; it looks at `cancelled` now and then.
  using Open = std::function<absl::StatusOr<Next>(const std::function<bool()>& cancelled)>;

  // `request` is open's to read.
  PartStream(ServerEnv* env, grpc::CallbackServerContext* context, const Rpc& rpc,
             const google::protobuf::Message& request, const std::string& scene, Open open)
      : room_(*env) {
    auto call = BeginCall(*env, context, rpc);
    if (!call.ok()) {
      this->Finish(ToGrpcStatus(call.status()));
      return;
    }
    call_ = *std::move(call);
    NoteScene(call_, scene);
    auto admitted = AdmitRequest(*env, request);
    if (!admitted.ok()) {
      End(ToGrpcStatus(admitted.status()));
      return;
    }
    request_room_ = *std::move(admitted);
    env->workers.Post([this, &request, open = std::move(open)] {
      auto next = CatchBadAlloc("the request", [&]() -> absl::StatusOr<Next> {
        if (cancelled_) return absl::CancelledError("the caller cancelled");
        return open([this] { return cancelled_.load(); });
      });
      FreeMessage(request);
      request_room_.Release();
      if (!next.ok()) return End(ToGrpcStatus(next.status()));
      next_ = *std::move(next);
      WriteNext();
    });
  }

  void OnWriteDone(bool ok) override {
    if (!ok || cancelled_) return End(grpc::Status::CANCELLED);
    WriteNext();
  }
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override { delete this; }

 private:
  void End(const grpc::Status& status) {
    LogFinished(call_, status);
    this->Finish(status);
  }
  void WriteNext() {
    auto message = CatchBadAlloc("the next part", next_);
    if (!message.ok()) return End(ToGrpcStatus(message.status()));
    if (!message->has_value()) return End(grpc::Status::OK);
    message_ = **std::move(message);
    if (auto s = room_.Hold(ReplyBytes(message_)); !s.ok()) return End(ToGrpcStatus(s));
    this->StartWrite(&message_);
  }

  CallInfo call_;
  std::atomic<bool> cancelled_ = false;
  MemoryReservation request_room_;  // while it waits
  Next next_;
  Message message_;
  ReplyRoom room_;  // for the largest so far
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_PART_STREAM_H_
