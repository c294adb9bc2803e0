// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A row of a service's table: the name of an rpc, the role that callers need, the handler, and the workers'
// lane: long, if the handler may take more than a few milliseconds.
//
//   constexpr UnaryMethod kGetScene{Rpc{"SceneService/GetScene", Role::kRead}, GetScene};
//   constexpr UnaryMethod kCreateScene{Rpc{…}, CreateScene, Lane::kLong};
//
//   grpc::ServerUnaryReactor* GetScene(…) override { return kGetScene.Run(env_, context, request, response); }
//
// Every call goes through the same steps:
//
//   Begin -> room for the request -> the handler on a worker -> room for the reply -> FinishCall
//
// A refused call changes nothing. So a handler that changes something, and whose reply may be large, takes
// room for the reply itself before it changes anything. A server stream of parts has one part in memory at
// a time; gRPC's flow control paces it.
//
// Threads  gRPC calls Run; handlers run on a worker, and so do functions that compute the parts of a stream. Parts of a
//          file, which are copied, are made where gRPC says that it has written the one before.
#ifndef LATTICED_SERVER_RPC_METHOD_H_
#define LATTICED_SERVER_RPC_METHOD_H_

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include "absl/status/statusor.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_reactor.h"

namespace latticed {

using Lane = WorkerLanes::Lane;

// What a handler gets in addition to its request and its reply.
struct CallContext {
  ServerEnv& env;
  const CallInfo& call;
  ReplyRoom& room;
};

// One request, one reply.
template <typename Request, typename Response>
using UnaryHandler = absl::Status (*)(const CallContext&, const Request&, Response&);

template <typename Request, typename Response>
class UnaryCall final : public CallReactor<grpc::ServerUnaryReactor> {
 public:
  UnaryCall(ServerEnv* env, grpc::CallbackServerContext* context, const Rpc& rpc,
            const grpc::ByteBuffer& request, grpc::ByteBuffer* reply,
            UnaryHandler<Request, Response> handler, Lane lane) {
    if (!Begin(*env, context, rpc)) return;
    room_.Open(*env, call_);
    const auto work = [=, this]() -> absl::Status {
      // It may have waited for long.
      LATTICED_RETURN_IF_ERROR(CheckTokenTime(call_.caller, absl::Now()));
      Response response;
      LATTICED_RETURN_IF_ERROR(handler({*env, call_, room_}, request_, response));
      LATTICED_RETURN_IF_ERROR(room_.Hold(ReplyBytes(response)));
      *reply = ToBytes(response);
      env->quotas.TakeBytes(call_.caller.tenant, reply->Length(), absl::Now());
      return absl::OkStatus();
    };
    Work(*env, lane, request, request_, work,
         [this](const absl::Status& result) { FinishCall(result); });
  }

 private:
  Request request_;
  ReplyRoom room_;
};

template <typename Request, typename Response>
struct UnaryMethod {
  Rpc rpc;
  UnaryHandler<Request, Response> handler;
  Lane lane = Lane::kQuick;

  grpc::ServerUnaryReactor* Run(ServerEnv* env, grpc::CallbackServerContext* context,
                                const grpc::ByteBuffer* request, grpc::ByteBuffer* reply) const {
    return new UnaryCall<Request, Response>(env, context, rpc, *request, reply, handler, lane);
  }
};

// Clang 14 deduces no aggregates by itself.
template <typename Request, typename Response>
UnaryMethod(Rpc, absl::Status (*)(const CallContext&, const Request&, Response&),
            Lane = Lane::kQuick) -> UnaryMethod<Request, Response>;

// Returns the next part of a stream, nullopt after the last.
template <typename Message>
using NextPart = std::function<absl::StatusOr<std::optional<Message>>()>;
// Checks the request and opens a stream of parts.
template <typename Request, typename Message>
using PartHandler = absl::StatusOr<NextPart<Message>> (*)(const CallContext&, const Request&);

// What a part takes: some milliseconds of computing, a copy, or reading from the store.
enum class Parts { kComputed, kCopied, kRead };

template <typename Request, typename Message>
class PartStream final : public CallReactor<grpc::ServerWriteReactor<grpc::ByteBuffer>> {
 public:
  PartStream(ServerEnv* env, grpc::CallbackServerContext* context, const Rpc& rpc,
             const grpc::ByteBuffer& request, PartHandler<Request, Message> open, Lane lane,
             Parts parts)
      : env_(*env), parts_(parts) {
    if (!Begin(*env, context, rpc)) return;
    room_.Open(*env, call_);
    const auto work = [=, this]() -> absl::Status {
      constexpr bool kWatches = false;
      LATTICED_RETURN_IF_ERROR(
          env->quotas.OpenStream(call_.caller.tenant, kWatches, absl::Now()).status());
      LATTICED_ASSIGN_OR_RETURN(next_, open({*env, call_, room_}, request_));
      return absl::OkStatus();
    };
    Work(*env, lane, request, request_, work,
         [this](const absl::Status& opened) { opened.ok() ? WriteNext() : FinishCall(opened); });
  }

  void OnWriteDone(bool ok) override {
    EndWrite();
    if (!ok) return FinishCall(grpc::Status::CANCELLED);
    if (parts_ == Parts::kCopied) return WriteNext();
    const Lane lane = parts_ == Parts::kRead ? Lane::kLong : Lane::kQuick;
    env_.Post(lane, *call_.account, [this] { WriteNext(); });
  }

 private:
  void WriteNext() {
    if (call_.context->IsCancelled()) return FinishCall(grpc::Status::CANCELLED);
    if (auto s = CheckTokenTime(call_.caller, absl::Now()); !s.ok()) return FinishCall(s);
    const auto message = CatchBadAlloc("the next part", next_);
    if (!message.ok()) return FinishCall(message.status());
    if (!message->has_value()) return FinishCall(grpc::Status::OK);
    if (auto s = room_.Hold(ReplyBytes(**message)); !s.ok()) return FinishCall(s);
    part_ = ToBytes(**message);
    if (open_at_ <= absl::Now()) return Send();
    pace_ = std::make_unique<grpc::Alarm>();
    pace_->Set(absl::ToChronoTime(open_at_), [this](bool) { Send(); });
  }

  void Send() {
    if (call_.context->IsCancelled()) return FinishCall(grpc::Status::CANCELLED);
    open_at_ = env_.quotas.TakeBytes(call_.caller.tenant, part_.Length(), absl::Now());
    BeginWrite();
    StartWrite(&part_);
  }

  ServerEnv& env_;
  const Parts parts_;
  Request request_;
  NextPart<Message> next_;
  grpc::ByteBuffer part_;
  absl::Time open_at_;                 // for the next part, by the tenant's quota of bytes
  std::unique_ptr<grpc::Alarm> pace_;  // an alarm runs once
  ReplyRoom room_;                     // for the largest part so far
};

template <typename Request, typename Message>
struct PartMethod {
  Rpc rpc;
  PartHandler<Request, Message> open;
  Parts parts;
  Lane lane = Lane::kQuick;  // of `open`

  grpc::ServerWriteReactor<grpc::ByteBuffer>* Run(ServerEnv* env,
                                                  grpc::CallbackServerContext* context,
                                                  const grpc::ByteBuffer* request) const {
    return new PartStream<Request, Message>(env, context, rpc, *request, open, lane, parts);
  }
};

template <typename Request, typename Message>
PartMethod(Rpc, absl::StatusOr<NextPart<Message>> (*)(const CallContext&, const Request&), Parts,
           Lane = Lane::kQuick) -> PartMethod<Request, Message>;

// A file as a stream of parts: a message with the header, then the bytes from `offset` on in messages of
// limits::kMaxPartBytes. `offset` is not beyond the end. The bytes are kept until the stream is done.
template <typename Message, typename Header>
NextPart<Message> FileParts(Header header, std::shared_ptr<const std::string> bytes,
                            size_t offset = 0) {
  return [header = std::optional(std::move(header)), bytes = std::move(bytes),
          offset]() mutable -> absl::StatusOr<std::optional<Message>> {
    Message part;
    if (header.has_value()) {
      *part.mutable_header() = *std::exchange(header, std::nullopt);
      return part;
    }
    if (offset == bytes->size()) return std::nullopt;
    const size_t size = std::min(limits::kMaxPartBytes, bytes->size() - offset);
    part.set_data(bytes->data() + offset, size);
    offset += size;
    return part;
  };
}

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_METHOD_H_
