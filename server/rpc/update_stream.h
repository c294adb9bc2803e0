// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reactor of a call that only writes: Watch and GetUpdate. It deletes itself when the call is
// done.
#ifndef LATTICED_SERVER_RPC_UPDATE_STREAM_H_
#define LATTICED_SERVER_RPC_UPDATE_STREAM_H_

#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/status/statusor.h"
#include "server/rpc/call.h"
#include "server/rpc/scene_stream.h"
#include "server/rpc/watch_request.h"
#include "server/wire/grpc_status.h"

namespace latticed {

// What such a call opens with: a message of the type Request, whose bytes are given back.
template <typename Request>
absl::StatusOr<OpenRequest> ReadOpenRequest(ServerEnv* env, CallInfo& call,
                                            const grpc::ByteBuffer& bytes) {
  Request request;
  const absl::Status parsed = ParseMessage(bytes, &request);
  FreeMessage(bytes);
  if (!parsed.ok()) return parsed;
  NoteScene(call, request.scene());
  return FromProto(env, *call.context, request);
}

class UpdateStream final : public grpc::ServerWriteReactor<grpc::ByteBuffer>, public StreamSink {
 public:
  // `open` reads the request and says in the call which scene it is about. Finishes at once when
  // the request was refused. gRPC holds back what is started here, and every reaction, until the
  // reactor is bound to its call.
  using Open = std::function<absl::StatusOr<OpenRequest>(CallInfo&)>;
  UpdateStream(ServerEnv* env, grpc::CallbackServerContext* context, const Rpc& rpc,
               const Open& open) {
    auto call = BeginCall(*env, context, rpc);
    if (!call.ok()) {
      ServerWriteReactor::Finish(ToGrpcStatus(call.status()));
      return;
    }
    call_ = *std::move(call);
    const auto request = open(call_);
    if (!request.ok()) {
      Finish(ToGrpcStatus(request.status()));
      return;
    }
    auto stream = SceneStream::Open(env, request->scene, request->options, this);
    if (stream.ok()) {
      stream_ = *std::move(stream);
      stream_->Start();
    } else {
      Finish(ToGrpcStatus(stream.status()));
    }
  }

  void Write(const grpc::ByteBuffer* buffer) override { StartWrite(buffer); }
  void Finish(const grpc::Status& status) override {
    LogFinished(call_, status);
    ServerWriteReactor::Finish(status);
  }

  void OnWriteDone(bool ok) override { stream_->OnWriteDone(ok); }
  void OnCancel() override {
    if (stream_ != nullptr) stream_->OnCancel();
  }
  void OnDone() override {
    if (stream_ != nullptr) stream_->Close();
    delete this;
  }

 private:
  CallInfo call_;
  std::shared_ptr<SceneStream> stream_;  // null when the request was refused
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPDATE_STREAM_H_
