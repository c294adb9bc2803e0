// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/closed_loop_editor.h"

#include <utility>

#include "absl/time/clock.h"
#include "client/cpp/library/status.h"
#include "core/base/status_macros.h"

namespace latticed::client {

absl::StatusOr<std::unique_ptr<LoadEditor>> ClosedLoopEditor::Open(std::unique_ptr<Client> client,
                                                                   v1::WatchRequest request,
                                                                   const Context& context) {
  std::unique_ptr<ClosedLoopEditor> editor(new ClosedLoopEditor(std::move(client), context));
  LATTICED_ASSIGN_OR_RETURN(
      auto stream,
      editor->client_->Deform(std::move(request), [self = editor.get()](const auto& event) {
        self->log_.Take(event);
      }));
  editor->stream_ = std::move(stream);
  return editor;
}

ClosedLoopEditor::ClosedLoopEditor(std::unique_ptr<Client> client, const Context& context)
    : client_(std::move(client)), context_(context) {}

void ClosedLoopEditor::Start(absl::Time begin) {
  thread_ = std::thread([this, begin] {
    absl::Status status;
    if (context_.control->SleepUntil(begin)) status = Edit();
    if (!status.ok()) Fail(status);
    done_.Notify();
    if (status.ok()) status = Watch();
    if (!status.ok()) Fail(status);
  });
}

absl::Status ClosedLoopEditor::WaitFor(uint64_t revision) {
  if (thread_.joinable()) return log_.WaitFor(revision);
  while (log_.revision() < revision) {  // nobody else reads yet
    LATTICED_RETURN_IF_ERROR(TakeNext());
  }
  return absl::OkStatus();
}

void ClosedLoopEditor::Close() {
  closing_ = true;
  if (stream_ != nullptr) stream_->Cancel();
  if (thread_.joinable()) thread_.join();
}

absl::Status ClosedLoopEditor::Edit() {
  for (uint64_t step = 0; step < context_.plan->edits && !context_.control->Ended(); ++step) {
    LATTICED_RETURN_IF_ERROR(EditOnce(step));
  }
  return absl::OkStatus();
}

absl::Status ClosedLoopEditor::EditOnce(uint64_t step) {
  const absl::Time due = absl::Now();
  LATTICED_ASSIGN_OR_RETURN(
      const auto sequence,
      stream_->Send(MakeLoadEdit(*context_.lattice, context_.plan->all_points, step)));
  while (applied_sequence_ < sequence) {
    LATTICED_RETURN_IF_ERROR(TakeNext());
  }
  context_.edits->Add({due}, context_.number, step, result_);
  context_.control->CountEdits(1);
  return absl::OkStatus();
}

absl::Status ClosedLoopEditor::Watch() {
  for (;;) {
    const absl::Status status = TakeNext();
    if (closing_) return absl::OkStatus();
    if (!status.ok()) return status;
  }
}

absl::Status ClosedLoopEditor::TakeNext() {
  LATTICED_ASSIGN_OR_RETURN(auto step, stream_->Next());
  if (step.ended()) return absl::UnavailableError("the server has ended a stream");
  if (step.result.has_value()) {
    result_ = *std::move(step.result);
    return FromRpc(result_.status());
  }
  applied_sequence_ = step.update->end.applied_sequence();
  absl::Status status;
  if (context_.decodes) status = log_.DecodeNewest(stream_->surface());
  if (context_.control->begun()) log_.SampleNewest(stream_->surface());
  return status;
}

void ClosedLoopEditor::Fail(const absl::Status& status) {
  if (closing_) return;
  context_.control->Fail(status);
  log_.Fail(status);
}

}  // namespace latticed::client
