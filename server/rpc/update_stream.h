// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reactor of a call that only writes: Watch, and GetUpdate, which is one full update at the newest
// revision.
#ifndef LATTICED_SERVER_RPC_UPDATE_STREAM_H_
#define LATTICED_SERVER_RPC_UPDATE_STREAM_H_

#include <memory>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "core/base/status_macros.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/scene_stream.h"
#include "server/rpc/watch_request.h"
#include "server/wire/message_bytes.h"

namespace latticed {

template <typename Request>
class UpdateStream final : public CallReactor<grpc::ServerWriteReactor<grpc::ByteBuffer>>,
                           public StreamSink {
 public:
  // `request` is the bytes of a Request.
  UpdateStream(ServerEnv* env, grpc::CallbackServerContext* context, const Rpc& rpc,
               const grpc::ByteBuffer& request) {
    if (!Begin(*env, context, rpc)) return;
    if (absl::Status opened = Open(env, request); !opened.ok()) FinishCall(opened);
  }

  void Write(const grpc::ByteBuffer* buffer) override {
    BeginWrite();
    StartWrite(buffer);
  }
  void Finish(const grpc::Status& status) override { FinishCall(status); }

  void OnWriteDone(bool ok) override {
    EndWrite();
    stream_->OnWriteDone(ok);
  }
  void OnCancel() override {
    if (stream_ != nullptr) stream_->OnCancel();
  }
  void OnDone() override {
    Done();
    if (stream_ != nullptr) stream_->Close();
    delete this;
  }

 private:
  absl::Status Open(ServerEnv* env, const grpc::ByteBuffer& bytes) {
    Request request;
    LATTICED_RETURN_IF_ERROR(TakeMessage(bytes, &request));
    NoteScene(call_, request.scene());
    LATTICED_ASSIGN_OR_RETURN(const OpenRequest open, FromProto(env, call_, request));
    LATTICED_ASSIGN_OR_RETURN(
        stream_, SceneStream::Open(env, *call_.account, open.scene, open.options, this));
    stream_->Start();
    return absl::OkStatus();
  }

  std::shared_ptr<SceneStream> stream_;  // null when the request was refused
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPDATE_STREAM_H_
