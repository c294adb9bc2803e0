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
#include "core/base/mutex.h"
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
    Request message;
    if (absl::Status s = TakeMessage(request, &message); !s.ok()) {
      FinishCall(s);
      return;
    }
    NoteScene(call_, message.scene());
    if (env->IsAsleep(message.scene())) {
      env->Post(WorkerLanes::Lane::kLong, *call_.account,
                [this, env, message = std::move(message)] { Open(env, message); });
    } else {
      Open(env, message);
    }
  }

  void Write(const grpc::ByteBuffer* buffer) override {
    BeginWrite();
    StartWrite(buffer);
  }
  void Finish(const grpc::Status& status) override { FinishCall(status); }

  void OnWriteDone(bool ok) override {
    EndWrite();
    Stream()->OnWriteDone(ok);
  }
  void OnCancel() override {
    // A stream that is still being opened notices with its first write.
    if (const auto stream = Stream(); stream != nullptr) stream->OnCancel();
  }
  void OnDone() override {
    Done();
    if (const auto stream = Stream(); stream != nullptr) stream->Close();
    delete this;
  }

 private:
  // The reactor may be deleted when this returns.
  void Open(ServerEnv* env, const Request& request) {
    auto opened = Opened(env, request);
    if (!opened.ok()) return FinishCall(opened.status());
    {
      const MutexLock lock(&mutex_);
      stream_ = *opened;
    }
    (*opened)->Start();
  }
  absl::StatusOr<std::shared_ptr<SceneStream>> Opened(ServerEnv* env, const Request& request) {
    LATTICED_ASSIGN_OR_RETURN(const OpenRequest open, FromProto(env, call_, request));
    return SceneStream::Open(env, *call_.account, open.scene, open.options, this);
  }
  std::shared_ptr<SceneStream> Stream() const {
    const MutexLock lock(&mutex_);
    return stream_;
  }

  mutable Mutex mutex_;
  std::shared_ptr<SceneStream> stream_
      ABSL_GUARDED_BY(mutex_);  // null when the request was refused
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPDATE_STREAM_H_
