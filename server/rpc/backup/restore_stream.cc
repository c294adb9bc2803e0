// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/backup/restore_stream.h"

#include <optional>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "latticed/v1/backup.pb.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/backup/restorer.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/first_message.h"
#include "server/rpc/server_env.h"
#include "server/wire/message_bytes.h"

namespace latticed {
namespace {

absl::Status NoOptions() {
  return error::FailedPrecondition("STREAM_NOT_OPENED", "the first message must be the options");
}

class RestoreStream final : public CallReactor<grpc::ServerReadReactor<grpc::ByteBuffer>> {
 public:
  RestoreStream(const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
                grpc::ByteBuffer* reply)
      : env_(env), reply_(reply) {
    if (!Begin(*env, context, rpc)) return;
    first_message_.Await(env->options.first_message_timeout, "the options",
                         [this](const absl::Status& late) { End(late); });
    StartRead(&bytes_);
  }

  void OnReadDone(bool ok) override {
    if (!first_message_.Arrive()) return;
    if (!ok) return OnAllRead();
    const absl::Status status = CatchBadAlloc("the restore", [this] { return Take(); });
    if (!status.ok()) return End(status);
    if (!restorer_->is_whole()) return StartRead(&bytes_);
    env_->Post(WorkerLanes::Lane::kLong, *call_.account, [this] {
      const absl::Status stored =
          CatchBadAlloc("the restore", [this] { return restorer_->Store(); });
      stored.ok() ? StartRead(&bytes_) : End(stored);
    });
  }

 private:
  absl::Status Take() {
    LATTICED_RETURN_IF_ERROR(CheckTokenTime(call_.caller, absl::Now()));
    LATTICED_RETURN_IF_ERROR(CheckDraining(*env_));
    v1::RestoreRequest request;
    LATTICED_RETURN_IF_ERROR(TakeMessage(bytes_, &request));
    if (restorer_.has_value()) {
      if (request.has_part()) return restorer_->Take(request.part());
      return error::InvalidField("options", "must be the first message and must not be repeated");
    }
    if (!request.has_options()) return NoOptions();
    restorer_.emplace(env_, &call_, request.options().skip_existing());
    StartSendInitialMetadata();  // a client may wait for it before it sends its parts
    return absl::OkStatus();
  }

  // The client has half-closed the stream, or has gone.
  void OnAllRead() {
    if (call_.context->IsCancelled()) return End(absl::CancelledError("the caller cancelled"));
    if (!restorer_.has_value()) return End(NoOptions());
    const auto done = restorer_->Finish();
    if (done.ok()) *reply_ = ToBytes(*done);
    End(done.status());
  }

  void End(const absl::Status& result) {
    restorer_.reset();  // its memory is free before the client gets the status
    FinishCall(result);
  }

  ServerEnv* const env_;
  grpc::ByteBuffer* const reply_;
  FirstMessage first_message_;
  grpc::ByteBuffer bytes_;            // of the message that comes next
  std::optional<Restorer> restorer_;  // once the options have come
};

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* NewRestoreStream(const Rpc& rpc, ServerEnv* env,
                                                            grpc::CallbackServerContext* context,
                                                            grpc::ByteBuffer* reply) {
  return new RestoreStream(rpc, env, context, reply);
}

}  // namespace latticed
