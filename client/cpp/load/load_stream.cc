// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_stream.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "client/cpp/library/status.h"
#include "client/cpp/load/load_edit.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

bool Decodes(const LoadPlan& plan, LoadStream::Kind kind, int number) {
  const bool editor = kind == LoadStream::Kind::kEditor;
  switch (plan.decoding) {
    case Decoding::kFirst:
      return editor && number == 0;
    case Decoding::kAll:
      return editor || kind == LoadStream::Kind::kWatcher;
    case Decoding::kNone:
      return false;
  }
  return false;
}

}  // namespace

absl::StatusOr<std::unique_ptr<LoadStream>> LoadStream::Open(std::unique_ptr<Client> client,
                                                             Kind kind, int number,
                                                             Context context) {
  std::unique_ptr<LoadStream> stream(
      new LoadStream(std::move(client), kind, number, std::move(context)));
  LATTICED_RETURN_IF_ERROR(stream->OpenStream());
  return stream;
}

LoadStream::LoadStream(std::unique_ptr<Client> client, Kind kind, int number, Context context)
    : client_(std::move(client)),
      kind_(kind),
      number_(number),
      context_(std::move(context)),
      decodes_(Decodes(*context_.plan, kind, number)) {}

absl::Status LoadStream::OpenStream() {
  v1::WatchRequest request;
  request.set_scene(context_.scene);
  *request.mutable_view() = context_.view;
  if (kind_ == Kind::kStalled) request.set_max_unacked_updates(0);
  const auto observer = [this](const v1::SceneEvent& event) { Take(event); };
  if (kind_ == Kind::kEditor && context_.plan->mode == LoadMode::kClosed) {
    LATTICED_ASSIGN_OR_RETURN(deform_, client_->Deform(std::move(request), observer));
  } else {
    LATTICED_ASSIGN_OR_RETURN(watch_, client_->Watch(std::move(request), observer));
  }
  return absl::OkStatus();
}

void LoadStream::Start(absl::Time begin) {
  if (kind_ == Kind::kStalled) return;
  started_ = true;
  if (kind_ == Kind::kEditor && deform_ == nullptr) {
    editor_ = std::thread([this, begin] {
      Fail(EditEveryPeriod(begin));
      edited_.Notify();
    });
  }
  reader_ = std::thread([this, begin] {
    absl::Status status;
    if (deform_ != nullptr) {
      status = EditInClosedLoop(begin);
      Fail(status);
      edited_.Notify();
    }
    while (status.ok()) status = Next();
    Fail(status);
  });
}

void LoadStream::WaitUntilEdited() {
  if (kind_ == Kind::kEditor) edited_.WaitForNotification();
}

absl::Status LoadStream::WaitFor(uint64_t revision) {
  if (started_) return log_.WaitFor(revision);
  while (log_.revision() < revision) {  // this thread must read: no other does before Start
    LATTICED_RETURN_IF_ERROR(Next());
  }
  return absl::OkStatus();
}

void LoadStream::Close() {
  if (editor_.joinable()) editor_.join();
  if (!closing_.HasBeenNotified()) closing_.Notify();
  if (deform_ != nullptr) deform_->Cancel();
  if (watch_ != nullptr) watch_->Cancel();
  if (reader_.joinable()) reader_.join();
}

void LoadStream::Take(const v1::SceneEvent& event) {
  log_.Take(event);
  if (kind_ != Kind::kSlow || !started_) return;
  const double seconds = static_cast<double>(event.ByteSizeLong()) / context_.plan->slow_rate;
  (void)closing_.WaitForNotificationWithTimeout(absl::Seconds(seconds));
}

absl::Status LoadStream::Next() {
  bool ended = false;
  if (deform_ != nullptr) {
    LATTICED_ASSIGN_OR_RETURN(auto step, deform_->Next());
    if (step.result.has_value()) {
      result_ = *std::move(step.result);
      return FromRpc(result_.status());
    }
    ended = step.ended();
    if (!ended) applied_sequence_ = step.update->end.applied_sequence();
  } else {
    LATTICED_ASSIGN_OR_RETURN(const auto update, watch_->Next());
    ended = !update.has_value();
  }
  if (ended) return absl::UnavailableError("the server has ended a stream");
  return decodes_ ? log_.DecodeNewest(surface()) : absl::OkStatus();
}

absl::Status LoadStream::EditInClosedLoop(absl::Time begin) {
  if (!context_.control->SleepUntil(begin)) return absl::OkStatus();
  const LoadPlan& plan = *context_.plan;
  for (uint64_t step = 0; step < plan.edits && !context_.control->Ended(); ++step) {
    const absl::Time due = absl::Now();
    LATTICED_ASSIGN_OR_RETURN(
        const auto sequence, deform_->Send(MakeLoadEdit(*context_.lattice, plan.all_points, step)));
    while (applied_sequence_ < sequence) {
      LATTICED_RETURN_IF_ERROR(Next());
    }
    context_.edits->Add({due}, result_);
    context_.control->CountEdits(1);
  }
  return absl::OkStatus();
}

absl::Status LoadStream::EditEveryPeriod(absl::Time begin) {
  const LoadPlan& plan = *context_.plan;
  const bool gesture = plan.mode == LoadMode::kInterval;
  const absl::Time first_due = begin + plan.period * number_ / plan.editors;
  const auto due_at = [&](uint64_t step) { return first_due + plan.period * step; };
  v1::EditBatch batch;
  const std::string editor = RandomEditorId();
  uint64_t sequence = 0;
  const auto send = [&](v1::GesturePhase phase) {
    batch.set_scene(context_.scene);
    batch.set_editor_id(editor);
    batch.set_sequence(++sequence);
    if (gesture) {
      batch.set_gesture_id("load");
      batch.set_gesture_phase(phase);
    }
    return client_->ApplyEdits(batch);
  };
  for (uint64_t step = 0; step < plan.edits && context_.control->SleepUntil(due_at(step));) {
    const double periods = absl::FDivDuration(absl::Now() - first_due, plan.period);
    const uint64_t newest =
        gesture ? std::clamp(static_cast<uint64_t>(periods), step, plan.edits - 1) : step;
    batch = MakeLoadEdit(*context_.lattice, plan.all_points, newest);
    std::vector<absl::Time> due;
    for (; step <= newest; ++step) due.push_back(due_at(step));
    LATTICED_ASSIGN_OR_RETURN(const auto result, send(v1::GESTURE_PHASE_UPDATE));
    context_.edits->Add(due, result);
    context_.control->CountEdits(due.size());
  }
  if (!gesture || sequence == 0) return absl::OkStatus();
  batch.clear_edits();
  return send(v1::GESTURE_PHASE_COMMIT).status();
}

void LoadStream::Fail(const absl::Status& status) {
  if (status.ok() || closing_.HasBeenNotified()) return;
  context_.control->Fail(status);
  log_.Fail(status);
}

}  // namespace latticed::client
