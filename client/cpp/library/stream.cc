// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/stream.h"

#include <algorithm>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kMostRefusals = 1024;
constexpr std::string_view kOutOfOrder = "OUT_OF_ORDER";
constexpr std::string_view kDraining = "DRAINING", kSceneMoved = "SCENE_MOVED";

}  // namespace

absl::StatusOr<std::unique_ptr<DeformStream>> DeformStream::Open(Client* client,
                                                                 v1::WatchRequest watch,
                                                                 EventObserver observer) {
  if (watch.editor_id().empty()) watch.set_editor_id(RandomEditorId());
  std::unique_ptr<DeformStream> stream(
      new DeformStream(client, std::move(watch), std::move(observer)));
  stream->Start();
  // With the first complete update the lattice is known, and the server has accepted the watch.
  LATTICED_ASSIGN_OR_RETURN(auto first, stream->Next());
  if (first.ended() && client->stop_.stop_requested()) return Stopped();
  stream->first_update_ = std::move(first.update);
  return stream;
}

DeformStream::DeformStream(Client* client, v1::WatchRequest watch, EventObserver observer)
    : ResumingStream(std::move(watch), client->reachability_.get(), client->stream_channel_.get(),
                     client->stop_, std::move(observer)),
      client_(client) {}

std::unique_ptr<grpc::ClientContext> DeformStream::NewContext() {
  return client_->NewContext(watch().scene());
}

std::unique_ptr<DeformStream::Rpc> DeformStream::OpenRpc(grpc::ClientContext* context) {
  auto rpc = client_->streams_->Deform(context);
  v1::DeformRequest request;
  *request.mutable_watch() = watch();
  bool open = rpc->Write(request);
  if (shown_.has_value()) {
    *request.mutable_presence() = *shown_;
    open = open && rpc->Write(request);
  }
  if (!unanswered_.empty()) resent_ = unanswered_.back().sequence();
  for (const v1::EditBatch& batch : unanswered_) {
    *request.mutable_edit() = batch;
    open = open && rpc->Write(request);
  }
  rpc_half_closed_ = half_closed_;
  if (open && half_closed_) rpc->WritesDone();
  return rpc;
}

void DeformStream::EndRequests() {
  if (!std::exchange(rpc_half_closed_, true) && rpc() != nullptr) rpc()->WritesDone();
}

void DeformStream::Write(const v1::DeformRequest& request) {
  // If the stream is broken, Next notices it, opens it again and sends the unanswered edits.
  if (!rpc_half_closed_) (void)rpc()->Write(request);
}

absl::StatusOr<uint64_t> DeformStream::Send(v1::EditBatch batch) {
  if (half_closed_ || rpc() == nullptr) {
    return absl::FailedPreconditionError("the stream takes no more edits");
  }
  // Updates report only sequences of the stream's own editor, so WaitFor could not see an edit of
  // another one.
  if (!batch.editor_id().empty() && batch.editor_id() != editor_id()) {
    return absl::InvalidArgumentError(
        fmt::format("editor_id: this stream is editor {}'s; {} needs its own stream", editor_id(),
                    batch.editor_id()));
  }
  if (batch.structure_id() == 0) batch.set_structure_id(surface_.lattice().structure_id());
  batch.set_sequence(++last_sequence_);
  v1::DeformRequest request;
  *request.mutable_edit() = batch;
  unanswered_.push_back(std::move(batch));
  Write(request);
  return last_sequence_;
}

absl::Status DeformStream::Show(v1::Presence presence) {
  if (half_closed_ || rpc() == nullptr) {
    return absl::FailedPreconditionError("the stream has ended");
  }
  presence.set_editor_id(editor_id());
  v1::DeformRequest request;
  *request.mutable_presence() = presence;
  shown_ = std::move(presence);
  Write(request);
  return absl::OkStatus();
}

void DeformStream::HalfClose() {
  half_closed_ = true;
  EndRequests();
}

absl::StatusOr<DeformStream::Step> DeformStream::Next() {
  for (;;) {
    LATTICED_ASSIGN_OR_RETURN(auto event, Read());
    if (!event.has_value()) return Step{};
    auto step = Take(*std::move(event));
    if (!step.ok()) Cancel();
    if (!step.ok() || !step->ended()) return step;
  }
}

absl::StatusOr<DeformStream::Step> DeformStream::Take(v1::SceneEvent event) {
  Step step;
  if (event.has_edit_result()) {
    if (IsForNextServer(event.edit_result())) return step;
    step.result = event.edit_result();
    if (IsLostAnswer(*step.result)) step.result->clear_status();
    Answer(*step.result);
    return step;
  }
  v1::DeformRequest request;
  if (event.has_heartbeat()) request.mutable_heartbeat();
  LATTICED_ASSIGN_OR_RETURN(step.update, surface_.Apply(std::move(event)));
  if (step.update.has_value()) {
    Remember(*step.update);
    request.mutable_control()->set_acked_update_id(step.update->end.update_id());
  }
  if (request.message_case() != v1::DeformRequest::MESSAGE_NOT_SET) Write(request);
  return step;
}

// The server that ends the stream did not take the edit. It stays unanswered, and is sent again to the next server.
bool DeformStream::IsForNextServer(const v1::EditResult& result) {
  if (result.status().code() == 0) return false;
  const std::string reason = error::DetailsOf(FromRpc(result.status())).reason;
  return reason == kDraining || reason == kSceneMoved;
}

// The edit was sent twice, and the server handled a later one before the connection broke. It handled
// this one too. The answer is lost, because the server keeps only an editor's last answer.
bool DeformStream::IsLostAnswer(const v1::EditResult& result) const {
  return result.sequence() <= resent_ && result.status().code() != 0 &&
         error::DetailsOf(FromRpc(result.status())).reason == kOutOfOrder;
}

void DeformStream::Answer(const v1::EditResult& result) {
  while (!unanswered_.empty() && unanswered_.front().sequence() <= result.sequence()) {
    unanswered_.pop_front();
  }
  if (result.status().code() == 0) return;
  refusals_[result.sequence()] = FromRpc(result.status());
  if (refusals_.size() > kMostRefusals) refusals_.erase(refusals_.begin());
}

void DeformStream::Remember(const CompleteUpdate& update) {
  Worked(update.end.resume_token());
  // An editor that sent edits before this stream continues above its old sequences.
  last_sequence_ = std::max(last_sequence_, update.end.applied_sequence());
  newest_update_ = update;
}

absl::StatusOr<CompleteUpdate> DeformStream::WaitFor(uint64_t sequence) {
  if (sequence == 0 || sequence > last_sequence_) {
    return absl::InvalidArgumentError(
        fmt::format("edit {} was never sent: the last one was {}", sequence, last_sequence_));
  }
  for (;;) {
    // Refusals are checked first: an update's sequence also passes those of refused edits.
    const auto refusal = refusals_.find(sequence);
    if (refusal != refusals_.end()) return refusal->second;
    if (newest_update_.has_value() && newest_update_->end.applied_sequence() >= sequence) {
      return *newest_update_;
    }
    LATTICED_ASSIGN_OR_RETURN(const auto step, Next());
    if (step.ended()) return absl::CancelledError("the stream ended before the edit was seen");
  }
}

}  // namespace latticed::client
