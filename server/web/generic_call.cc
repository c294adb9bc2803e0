// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/generic_call.h"

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/client_callback.h>

#include <map>
#include <optional>

#include "core/base/mutex.h"

namespace latticed::web {
namespace {

CallMetadata Copied(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) {
  CallMetadata result;
  for (const auto& [key, value] : metadata) {
    result.emplace_back(std::string(key.data(), key.size()),
                        std::string(value.data(), value.size()));
  }
  return result;
}

class BytesCall final : public GenericCall,
                        private grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                        public std::enable_shared_from_this<BytesCall> {
 public:
  BytesCall(Post post, std::shared_ptr<CallObserver> observer)
      : post_(std::move(post)), observer_(std::move(observer)) {}

  void Begin(const ServerChannel& server, const Request& request);

  void Write(const grpc::ByteBuffer& message) override ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    if (released_) return;
    writing_ = message;
    StartWrite(&writing_);
  }
  void WritesDone() override ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    if (!released_) StartWritesDone();
  }
  void Read() override ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    if (!released_) StartRead(&reading_);
  }
  void Cancel() override {
    context_.TryCancel();
    Release();
  }

 private:
  void OnReadInitialMetadataDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Hand(const grpc::ByteBuffer& message) {
    post_([observer = observer_, message] { observer->OnMessage(message); });
  }
  // No more operations will be started: lets OnDone come.
  void Release() ABSL_LOCKS_EXCLUDED(mutex_);

  const Post post_;
  std::shared_ptr<CallObserver> observer_;  // until OnDone
  std::shared_ptr<BytesCall> self_;         // gRPC's reference, until OnDone
  grpc::ClientContext context_;
  grpc::ByteBuffer reading_, writing_;
  Mutex mutex_;
  bool released_ ABSL_GUARDED_BY(mutex_) = false;
  bool head_read_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<grpc::ByteBuffer> early_ ABSL_GUARDED_BY(mutex_);  // read before the head
};

void BytesCall::Begin(const ServerChannel& server, const Request& request) {
  self_ = shared_from_this();
  for (const auto& [key, value] : request.metadata) context_.AddMetadata(key, value);
  context_.AddMetadata(server.peer_key, request.peer);
  if (request.deadline != absl::InfiniteFuture()) {
    context_.set_deadline(absl::ToChronoTime(request.deadline));
  }
  grpc::GenericStub stub(server.channel);
  stub.PrepareBidiStreamingCall(&context_, request.method, {}, this);
  AddHold();  // operations are started from outside of the reactions
  StartCall();
}

void BytesCall::Release() {
  {
    const MutexLock lock(&mutex_);
    if (released_) return;
    released_ = true;
  }
  RemoveHold();
}

void BytesCall::OnReadInitialMetadataDone(bool ok) {
  if (ok) {
    post_([observer = observer_, metadata = Copied(context_.GetServerInitialMetadata())]() mutable {
      observer->OnHead(std::move(metadata));
    });
  }
  const MutexLock lock(&mutex_);
  head_read_ = true;
  if (early_.has_value()) Hand(*early_);
  early_.reset();
}

void BytesCall::OnReadDone(bool ok) {
  if (!ok) return Release();
  grpc::ByteBuffer message;
  message.Swap(&reading_);
  const MutexLock lock(&mutex_);
  if (head_read_) return Hand(message);
  early_ = message;
}

void BytesCall::OnWriteDone(bool ok) {
  writing_.Clear();
  // A call that takes no more has a status, which a read brings.
  if (ok) post_([observer = observer_] { observer->OnWritten(); });
}

void BytesCall::OnDone(const grpc::Status& status) {
  post_([observer = std::move(observer_), status,
         trailers = Copied(context_.GetServerTrailingMetadata())]() mutable {
    observer->OnEnd(status, std::move(trailers));
  });
  self_ = nullptr;
}

}  // namespace

std::shared_ptr<GenericCall> GenericCall::Start(const ServerChannel& server, const Request& request,
                                                Post post, std::shared_ptr<CallObserver> observer) {
  const auto call = std::make_shared<BytesCall>(std::move(post), std::move(observer));
  call->Begin(server, request);
  return call;
}

}  // namespace latticed::web
