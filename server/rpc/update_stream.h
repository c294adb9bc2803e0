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
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/scene_stream.h"
#include "server/rpc/watch_request.h"
#include "server/wire/message_bytes.h"

namespace latticed {

template <typename Request>
class UpdateStream final : public CallReactor<grpc::ServerWriteReactor<grpc::ByteBuffer>>,
                           public StreamSink,
                           public std::enable_shared_from_this<UpdateStream<Request>> {
 public:
  // Begins the call. `request` is the bytes of a Request. gRPC keeps the result until OnDone.
  static grpc::ServerWriteReactor<grpc::ByteBuffer>* New(ServerEnv* env,
                                                         grpc::CallbackServerContext* context,
                                                         const Rpc& rpc,
                                                         const grpc::ByteBuffer& request) {
    const auto call = std::make_shared<UpdateStream>();
    call->self_ = call;
    if (call->Begin(*env, context, rpc)) call->Open(env, request);
    return call.get();
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
    std::shared_ptr<SceneStream> stream;
    {
      const MutexLock lock(&mutex_);
      cancelled_ = true;
      stream = stream_;
    }
    // A stream that is still being opened is cancelled by Open.
    if (stream != nullptr) stream->OnCancel();
  }
  void OnDone() override {
    Done();
    if (const auto stream = Stream(); stream != nullptr) stream->Close();
    self_ = nullptr;  // deletes this, unless a worker still opens the stream
  }

 private:
  void Open(ServerEnv* env, const grpc::ByteBuffer& bytes) {
    Request request;
    if (absl::Status s = TakeMessage(bytes, &request); !s.ok()) return FinishCall(s);
    NoteScene(call_, request.scene());
    if (!env->IsAsleep(KeyFor(call_, request.scene()))) return Open(env, request);
    auto room = AdmitRequest(*env, call_, request);
    if (!room.ok()) return FinishCall(room.status());
    env->Post(WorkerLanes::Lane::kLong, *call_.account,
              [self = this->shared_from_this(), env, request = std::move(request),
               room = std::make_shared<MemoryReservation>(*std::move(room))] {
                self->Open(env, request);
              });
  }
  void Open(ServerEnv* env, const Request& request) {
    const auto opened = CatchBadAlloc("the stream", [&] { return Opened(env, request); });
    if (!opened.ok()) return FinishCall(opened.status());
    bool cancelled;
    {
      const MutexLock lock(&mutex_);
      stream_ = *opened;
      cancelled = cancelled_;
    }
    token_end_.EndWith(call_.caller, *opened);
    (*opened)->Start();
    if (cancelled) (*opened)->OnCancel();
  }
  absl::StatusOr<std::shared_ptr<SceneStream>> Opened(ServerEnv* env, const Request& request) {
    LATTICED_ASSIGN_OR_RETURN(const OpenRequest open, FromProto(env, call_, request));
    return SceneStream::Open(env, *call_.account, open.scene, open.options, this);
  }
  std::shared_ptr<SceneStream> Stream() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    return stream_;
  }

  std::shared_ptr<UpdateStream> self_;
  TokenEnd token_end_;
  mutable Mutex mutex_;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<SceneStream> stream_ ABSL_GUARDED_BY(mutex_);  // null until it is open
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_UPDATE_STREAM_H_
