// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/upload_stream.h"

#include <memory>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/call.h"
#include "server/rpc/first_message.h"
#include "server/rpc/reply_room.h"
#include "server/rpc/server_env.h"
#include "server/rpc/store_upload.h"
#include "server/stores/upload_store.h"
#include "server/wire/grpc_status.h"
#include "server/wire/mesh_header.h"

namespace latticed {
namespace {

class UploadStream final : public grpc::ServerReadReactor<v1::UploadMeshRequest> {
 public:
  UploadStream(const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
               v1::Mesh* response)
      : env_(env), context_(context), response_(response), reply_room_(*env) {
    absl::StatusOr<CallInfo> call = BeginCall(*env, context, rpc);
    if (!call.ok()) {
      Finish(ToGrpcStatus(call.status()));
      return;
    }
    call_ = *std::move(call);
    first_message_.Await(env->options.first_message_timeout, "the header",
                         [this](const absl::Status& late) { End(late); });
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!first_message_.Arrive()) return;
    if (!ok) return OnAllRead();
    const absl::Status status = CatchBadAlloc("the upload", [this] { return Take(); });
    if (!status.ok()) return End(status);
    StartRead(&request_);
  }

  void OnDone() override { delete this; }

 private:
  absl::Status Take() {
    if (upload_ == nullptr) return TakeHeader();
    if (request_.has_data()) return upload_->Append(request_.data());
    return error::InvalidField("header", "comes first, and once");
  }

  absl::Status TakeHeader() {
    if (!request_.has_header()) return NotOpened();
    LATTICED_ASSIGN_OR_RETURN(UploadHeader header,
                              FromProto(request_.header(), env_->options.max_mesh_bytes));
    header.mesh.owner = call_.caller.name;
    LATTICED_ASSIGN_OR_RETURN(upload_, env_->uploads->Admit(std::move(header)));
    StartSendInitialMetadata();  // tells a client that waits for it that its bytes are welcome
    return absl::OkStatus();
  }

  // The client has half-closed, or is gone.
  void OnAllRead() {
    if (context_->IsCancelled()) return End(absl::CancelledError("the caller cancelled"));
    if (upload_ == nullptr) return End(NotOpened());
    env_->workers.Post([this] { End(CatchBadAlloc("the upload", [this] { return Store(); })); });
  }

  absl::Status Store() {
    request_ = v1::UploadMeshRequest();  // its bytes
    absl::Status status = StoreUpload(
        *env_, *upload_, [this] { return context_->IsCancelled(); }, reply_room_, *response_);
    if (!status.ok()) *response_ = v1::Mesh();
    return status;
  }

  void End(const absl::Status& result) {
    upload_.reset();  // gives back its bytes before the client hears
    const grpc::Status status = ToGrpcStatus(result);
    LogFinished(call_, status);
    Finish(status);
  }

  static absl::Status NotOpened() {
    return error::FailedPrecondition("STREAM_NOT_OPENED", "the first message must be the header");
  }

  ServerEnv* const env_;
  grpc::CallbackServerContext* const context_;
  v1::Mesh* const response_;
  CallInfo call_;
  FirstMessage first_message_;
  v1::UploadMeshRequest request_;
  std::shared_ptr<Upload> upload_;  // null until the header is admitted
  ReplyRoom reply_room_;
};

}  // namespace

grpc::ServerReadReactor<v1::UploadMeshRequest>* NewUploadStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, v1::Mesh* response) {
  return new UploadStream(rpc, env, context, response);
}

}  // namespace latticed
