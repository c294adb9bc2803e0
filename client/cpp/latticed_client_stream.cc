// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticed_client_stream.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticed_client.h"
#include "client/cpp/latticed_client_reply.h"
#include "client/cpp/latticed_client_status.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kMostRefusals = 1024;

absl::Duration ToDuration(const google::protobuf::Duration& duration) {
  return absl::Seconds(duration.seconds()) + absl::Nanoseconds(duration.nanos());
}

}  // namespace

absl::StatusOr<std::unique_ptr<DeformStream>> DeformStream::Open(Client* client,
                                                                 v1::WatchRequest watch) {
  if (watch.editor_id().empty()) watch.set_editor_id(RandomEditorId());
  std::unique_ptr<DeformStream> stream(new DeformStream(client, std::move(watch)));
  stream->Start();
  // The first complete update: what edits are relative to is then known, and errors are told here.
  auto first = stream->Next();
  if (!first.ok()) return first.status();
  stream->first_update_ = std::move(first->update);
  return stream;
}

DeformStream::DeformStream(Client* client, v1::WatchRequest watch)
    : client_(client), watch_(std::move(watch)) {}

DeformStream::~DeformStream() {
  if (stream_ == nullptr) return;
  Cancel();
  v1::SceneEvent event;
  while (stream_->Read(&event)) {
  }
  (void)stream_->Finish();
}

void DeformStream::Start() {
  {
    const std::lock_guard lock(context_mutex_);
    stream_.reset();
    context_ = client_->NewContext(watch_.scene());
    if (cancelled_) context_->TryCancel();
  }
  goaway_ = false;
  stream_ = client_->scenes_->Deform(context_.get());
  v1::DeformRequest request;
  *request.mutable_watch() = watch_;
  bool open = stream_->Write(request);
  for (const v1::EditBatch& batch : unanswered_) {
    *request.mutable_edit() = batch;
    open = open && stream_->Write(request);
  }
  if (open && half_closed_) stream_->WritesDone();
}

absl::StatusOr<bool> DeformStream::Restart() {
  const absl::Status status = FromGrpc(stream_->Finish(), *context_);
  stream_.reset();
  surface_.DropPartialUpdate();
  const bool done = status.ok() && !goaway_;
  if (done || cancelled_) return true;
  if (!status.ok()) {
    if (auto fatal = reopening_.AfterBreak(status); !fatal.ok()) return fatal;
  }
  ++reconnections_;
  Start();
  return false;
}

absl::StatusOr<uint64_t> DeformStream::Send(v1::EditBatch batch) {
  if (half_closed_ || stream_ == nullptr) {
    return absl::FailedPreconditionError("the stream takes no more edits");
  }
  if (batch.structure_id() == 0) batch.set_structure_id(surface_.lattice().structure_id());
  batch.set_sequence(++last_sequence_);
  v1::DeformRequest request;
  *request.mutable_edit() = batch;
  unanswered_.push_back(std::move(batch));
  // A broken stream is noticed by Next, which opens it again and sends what is unanswered.
  (void)stream_->Write(request);
  return last_sequence_;
}

void DeformStream::HalfClose() {
  if (!std::exchange(half_closed_, true) && stream_ != nullptr) stream_->WritesDone();
}

void DeformStream::Cancel() {
  cancelled_ = true;
  const std::lock_guard lock(context_mutex_);
  if (context_ != nullptr) context_->TryCancel();
}

absl::StatusOr<DeformStream::Step> DeformStream::Next() {
  while (stream_ != nullptr) {
    v1::SceneEvent event;
    if (!stream_->Read(&event)) {
      const auto ended = Restart();
      if (!ended.ok()) return ended.status();
      if (*ended) return Step{};
      continue;
    }
    auto step = Take(std::move(event));
    if (!step.ok()) Cancel();
    if (!step.ok() || !step->ended()) return step;
  }
  return Step{};
}

absl::StatusOr<DeformStream::Step> DeformStream::Take(v1::SceneEvent event) {
  Step step;
  switch (event.event_case()) {
    case v1::SceneEvent::kHello:
      hello_ = event.hello();
      return step;
    case v1::SceneEvent::kEditResult:
      step.result = event.edit_result();
      Answer(*step.result);
      return step;
    case v1::SceneEvent::kHeartbeat: {
      if (half_closed_) return step;
      v1::DeformRequest request;
      request.mutable_heartbeat();
      (void)stream_->Write(request);
      return step;
    }
    case v1::SceneEvent::kGoaway:
      goaway_ = true;
      absl::SleepFor(ToDuration(event.goaway().retry_after()));
      return step;
    default:
      break;
  }
  auto update = surface_.Apply(std::move(event));
  if (!update.ok()) return update.status();
  step.update = *std::move(update);
  if (step.update.has_value()) {
    reopening_.Worked();
    Remember(*step.update);
    Acknowledge(step.update->end.update_id());
  }
  return step;
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
  watch_.set_resume_token(update.end.resume_token());
  // An editor that edited before this stream goes on above its old sequences.
  last_sequence_ = std::max(last_sequence_, update.end.applied_sequence());
  newest_update_ = update;
}

void DeformStream::Acknowledge(uint64_t update_id) {
  if (half_closed_) return;
  v1::DeformRequest request;
  request.mutable_control()->set_acked_update_id(update_id);
  (void)stream_->Write(request);
}

absl::StatusOr<CompleteUpdate> DeformStream::WaitFor(uint64_t sequence) {
  if (sequence == 0 || sequence > last_sequence_) {
    return absl::InvalidArgumentError(
        fmt::format("edit {} was never sent: the last one was {}", sequence, last_sequence_));
  }
  for (;;) {
    // A refusal first: its sequence may lie below that of an edit which an update holds.
    const auto refusal = refusals_.find(sequence);
    if (refusal != refusals_.end()) return refusal->second;
    if (newest_update_.has_value() && newest_update_->end.applied_sequence() >= sequence) {
      return *newest_update_;
    }
    const auto step = Next();
    if (!step.ok()) return step.status();
    if (step->ended()) return absl::CancelledError("the stream ended before the edit was seen");
  }
}

}  // namespace latticed::client
