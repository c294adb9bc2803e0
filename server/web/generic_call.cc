// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/generic_call.h"

#include <grpcpp/channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <map>

namespace latticed::web {
namespace {

CallMetadata Copied(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) {
  CallMetadata result;
  for (const auto& [key, value] : metadata) {
    result.push_back(
        {std::string(key.data(), key.size()), std::string(value.data(), value.size())});
  }
  return result;
}

}  // namespace

std::vector<grpc::Slice> SlicesOf(const grpc::ByteBuffer& message) {
  std::vector<grpc::Slice> slices;
  (void)message.Dump(&slices);  // fails only if compressed; the channel has decompressed it
  return slices;
}

std::shared_ptr<GenericCall> GenericCall::Start(const ServerChannel& server, const Request& request,
                                                std::shared_ptr<CallObserver> observer) {
  const auto call = std::make_shared<GenericCall>(std::move(observer));
  call->self_ = call;
  for (const auto& [key, value] : request.metadata) call->context_.AddMetadata(key, value);
  call->context_.AddMetadata(server.peer_key, request.peer);
  if (request.deadline != absl::InfiniteFuture()) {
    call->context_.set_deadline(absl::ToChronoTime(request.deadline));
  }
  grpc::GenericStub stub(server.channel);
  stub.PrepareBidiStreamingCall(&call->context_, request.method, {}, call.get());
  call->AddHold();  // operations are also started outside of gRPC's callbacks
  call->StartCall();
  call->Read();  // at once: an in-process channel drops messages of an ended call
  return call;
}

void GenericCall::Write(const std::string& message) {
  const grpc::Slice slice(message);
  const MutexLock lock(&mutex_);
  if (released_) return;
  writing_ = grpc::ByteBuffer(&slice, 1);
  StartWrite(&writing_);
}

void GenericCall::WritesDone() {
  const MutexLock lock(&mutex_);
  if (!released_) StartWritesDone();
}

void GenericCall::Read() {
  const MutexLock lock(&mutex_);
  if (!released_) StartRead(&reading_);
}

void GenericCall::Cancel() {
  context_.TryCancel();
  Release();
}

void GenericCall::Release() {
  {
    const MutexLock lock(&mutex_);
    if (released_) return;
    released_ = true;
  }
  RemoveHold();
}

void GenericCall::OnReadInitialMetadataDone(bool ok) {
  if (ok) {
    observer_->Post(
        [observer = observer_, metadata = Copied(context_.GetServerInitialMetadata())]() mutable {
          observer->OnHead(std::move(metadata));
        });
  }
  const MutexLock lock(&mutex_);
  head_read_ = true;
  if (early_.has_value()) Hand(*early_);
  early_.reset();
}

void GenericCall::OnReadDone(bool ok) {
  if (!ok) return Release();
  grpc::ByteBuffer message;
  message.Swap(&reading_);
  const MutexLock lock(&mutex_);
  if (head_read_) return Hand(message);
  early_ = message;
}

void GenericCall::Hand(const grpc::ByteBuffer& message) {
  observer_->Post([observer = observer_, message] { observer->OnMessage(message); });
}

void GenericCall::OnWriteDone(bool ok) {
  writing_.Clear();
  // A failed write means that the call has ended. The next read then fails too, and OnDone brings the status.
  if (ok) observer_->Post([observer = observer_] { observer->OnWritten(); });
}

void GenericCall::OnDone(const grpc::Status& status) {
  const std::shared_ptr<CallObserver> observer = std::exchange(observer_, nullptr);
  observer->Post(
      [observer, status, trailers = Copied(context_.GetServerTrailingMetadata())]() mutable {
        observer->OnEnd(status, std::move(trailers));
      });
  self_ = nullptr;
}

}  // namespace latticed::web
