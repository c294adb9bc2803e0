// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A call whose client sends a header, then raw bytes in parts, then half-closes, and gets one message.
//
//   kHeader --header--> Receiver::Open (on a worker) --> kParts --half-close--> Receiver::Finish (on a worker) --> done
//   A header that does not come within --first-message-timeout ends the call. Initial metadata is sent when the header
//   is admitted. Any refusal or cancellation ends the call at once and drops what came.
//
// The bytes are reserved as they come, not when they are announced. They are whole doubles: a Receiver gets them as such.
//
//   struct Receiver {
//     using Request = …; using Response = …;   // a oneof of `header` and `data`
//     Receiver(ServerEnv& env, const CallInfo& call);
//     absl::StatusOr<uint64_t> Open(const Header& header);                      // the bytes to come
//     absl::Status Finish(std::vector<double> data, Response& response);
//   };
//
// Threads  as gRPC calls a reactor; it deletes itself when the call is done
#ifndef LATTICED_SERVER_RPC_POINTS_DATA_STREAM_H_
#define LATTICED_SERVER_RPC_POINTS_DATA_STREAM_H_

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/first_message.h"
#include "server/rpc/server_env.h"
#include "server/stores/callers.h"
#include "server/wire/message_bytes.h"

namespace latticed {

// Bytes of points as they come.
class ArrivingDoubles {
 public:
  // kResourceExhausted where so many bytes can never fit.
  [[nodiscard]] absl::Status Expect(ServerEnv& env, const MemoryAccountPtr& account,
                                    uint64_t bytes) {
    expected_ = bytes;
    if (const uint64_t most = env.memory->total_bytes(); bytes > most) {
      return error::OutOfMemory(kWhat, bytes, most);
    }
    LATTICED_ASSIGN_OR_RETURN(memory_, env.memory->Reserve(kWhat, 0, account));
    doubles_.reserve(bytes / sizeof(double));  // takes no memory before it is written
    return absl::OkStatus();
  }
  // kInvalidArgument, reasons INVALID_FIELD, OUT_OF_RANGE and SIZE_MISMATCH; kResourceExhausted.
  [[nodiscard]] absl::Status Append(const std::string& part) {
    if (part.empty() || part.size() > limits::kMaxPartBytes) {
      return error::OutOfRange("data", static_cast<double>(part.size()), 1,
                               static_cast<double>(limits::kMaxPartBytes));
    }
    if (part.size() % sizeof(double) != 0) {
      return error::InvalidField("data", "must be cut between two doubles");
    }
    const uint64_t before = doubles_.size() * sizeof(double), after = before + part.size();
    if (after > expected_) return SizeMismatch(after);
    if (after > memory_.bytes()) {
      LATTICED_RETURN_IF_ERROR(memory_.Resize(kWhat, std::min(expected_, after + kStepBytes)));
    }
    doubles_.resize(after / sizeof(double));
    std::memcpy(reinterpret_cast<char*>(doubles_.data()) + before, part.data(), part.size());
    return absl::OkStatus();
  }
  // SIZE_MISMATCH where bytes are missing.
  [[nodiscard]] absl::Status CheckWhole() const {
    const uint64_t came = doubles_.size() * sizeof(double);
    return came == expected_ ? absl::OkStatus() : SizeMismatch(came);
  }
  [[nodiscard]] std::vector<double> Take() { return std::move(doubles_); }

 private:
  static constexpr char kWhat[] = "the points";
  static constexpr uint64_t kStepBytes = uint64_t{4} << 20;

  absl::Status SizeMismatch(uint64_t came) const {
    return error::InvalidField(
        "data", fmt::format("{} bytes came, {} were announced", came, expected_), "SIZE_MISMATCH");
  }

  uint64_t expected_ = 0;
  std::vector<double> doubles_;
  MemoryReservation memory_;  // until the call ends
};

template <class Receiver>
class DataStream final : public CallReactor<grpc::ServerReadReactor<grpc::ByteBuffer>> {
 public:
  DataStream(const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
             grpc::ByteBuffer* reply)
      : env_(env), reply_(reply) {
    if (!this->Begin(*env, context, rpc)) return;
    room_.Open(*env, this->call_);
    first_message_.Await(env->options.first_message_timeout, "the header",
                         [this](const absl::Status& late) { End(late); });
    this->StartRead(&bytes_);
  }

  void OnReadDone(bool ok) override {
    if (!first_message_.Arrive()) return;
    if (!ok) return OnAllRead();
    request_ = Request();
    const absl::Status status = CatchBadAlloc("the points", [this] { return Take(); });
    if (!status.ok()) return End(status);
    if (receiver_.has_value()) return this->StartRead(&bytes_);
    env_->Post(WorkerLanes::Lane::kLong, *this->call_.account, [this] {
      const absl::Status opened = CatchBadAlloc("the points", [this] { return Open(); });
      if (!opened.ok()) return End(opened);
      this->StartSendInitialMetadata();  // a client may wait for it before it sends its parts
      this->StartRead(&bytes_);
    });
  }

 private:
  using Request = typename Receiver::Request;

  absl::Status Take() {
    LATTICED_RETURN_IF_ERROR(CheckTokenTime(this->call_.caller, absl::Now()));
    LATTICED_RETURN_IF_ERROR(TakeMessage(bytes_, &request_));
    if (!receiver_.has_value()) return request_.has_header() ? absl::OkStatus() : NotOpened();
    if (request_.has_data()) return arriving_.Append(request_.data());
    return error::InvalidField("header", "must be the first message and must not be repeated");
  }

  absl::Status Open() {
    NoteScene(this->call_, request_.header().scene());
    receiver_.emplace(*env_, this->call_);
    LATTICED_ASSIGN_OR_RETURN(const uint64_t bytes, receiver_->Open(request_.header()));
    return arriving_.Expect(*env_, this->call_.account->memory, bytes);
  }

  // The client has half-closed the stream, or has gone.
  void OnAllRead() {
    if (this->call_.context->IsCancelled()) {
      return End(absl::CancelledError("the caller cancelled"));
    }
    if (!receiver_.has_value()) return End(NotOpened());
    env_->Post(WorkerLanes::Lane::kLong, *this->call_.account,
               [this] { End(CatchBadAlloc("the points", [this] { return Finish(); })); });
  }

  absl::Status Finish() {
    LATTICED_RETURN_IF_ERROR(CheckTokenTime(this->call_.caller, absl::Now()));
    LATTICED_RETURN_IF_ERROR(arriving_.CheckWhole());
    typename Receiver::Response response;
    LATTICED_RETURN_IF_ERROR(receiver_->Finish(arriving_.Take(), response));
    LATTICED_RETURN_IF_ERROR(room_.Hold(ReplyBytes(response)));
    *reply_ = ToBytes(response);
    env_->quotas.TakeBytes(this->call_.caller.tenant, reply_->Length(), absl::Now());
    return absl::OkStatus();
  }

  void End(const absl::Status& result) {
    receiver_.reset();
    arriving_ = ArrivingDoubles();  // its memory is free before the client gets the status
    this->FinishCall(result);
  }

  static absl::Status NotOpened() {
    return error::FailedPrecondition("STREAM_NOT_OPENED", "the first message must be the header");
  }

  ServerEnv* const env_;
  grpc::ByteBuffer* const reply_;
  FirstMessage first_message_;
  grpc::ByteBuffer bytes_;            // of the message that comes next
  Request request_;                   // the newest message
  std::optional<Receiver> receiver_;  // once the header has come
  ArrivingDoubles arriving_;
  ReplyRoom room_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_POINTS_DATA_STREAM_H_
