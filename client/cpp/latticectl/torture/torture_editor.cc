// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/torture_editor.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kLongestSleep = absl::Milliseconds(20);
constexpr absl::Duration kLeastPutOff = absl::Milliseconds(20);
constexpr absl::Duration kMostPutOff = absl::Seconds(1);

// The server is well, but could not take the edit.
bool IsPutOff(const absl::Status& refusal) {
  return absl::IsUnavailable(refusal) || absl::IsResourceExhausted(refusal) ||
         error::DetailsOf(refusal).reason == "STORE";
}

// The state of the scene did not allow the edit, because another editor was faster, or there is nothing to undo.
bool IsExpected(const absl::Status& refusal) {
  const std::string reason = error::DetailsOf(refusal).reason;
  return reason == "STRUCTURE_CHANGED" || reason == "UNDO_CONFLICT" ||
         reason == "NOTHING_TO_UNDO" || reason == "NOTHING_TO_REDO";
}

}  // namespace

absl::Status TortureEditor::Open() {
  v1::WatchRequest watch;
  watch.set_scene(context_.model->scene());
  watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);  // little work for the server
  LATTICED_ASSIGN_OR_RETURN(stream_, context_.client->Deform(std::move(watch)));
  return absl::OkStatus();
}

absl::Status TortureEditor::Run(const std::function<bool()>& ended) {
  LATTICED_RETURN_IF_ERROR(Open());
  absl::Time due = absl::Now();
  while (!ended()) {
    const absl::Time now = absl::Now();
    if (now < due) {
      absl::SleepFor(std::min(due - now, kLongestSleep));
      continue;
    }
    LATTICED_RETURN_IF_ERROR(Edit(now, ended));
    CountReconnections();
    due = std::max(due + context_.period, absl::Now());
  }
  return absl::OkStatus();
}

absl::Status TortureEditor::Edit(absl::Time due, const std::function<bool()>& ended) {
  while (true) {
    EditBatch batch = edits_.Next(stream_->surface().lattice());
    batch.editor_id = stream_->editor_id();
    context_.model->Begin();
    LATTICED_ASSIGN_OR_RETURN(batch.sequence, stream_->Send(ToProto(batch)));
    LATTICED_ASSIGN_OR_RETURN(const auto result, AwaitResult(batch.sequence));
    const absl::Status status = FromRpc(result.status());
    if (status.ok()) {
      context_.model->Acknowledged(std::move(batch), result);
      context_.counts->Acknowledged(context_.model->scene(), absl::Now() - due);
      return absl::OkStatus();
    }
    const bool put_off = IsPutOff(status);
    if (!put_off && !IsExpected(status)) return status;
    context_.model->Refused(std::move(batch), put_off);
    context_.counts->Refused(put_off);
    if (!put_off || ended()) return absl::OkStatus();
    const auto wait = absl::Milliseconds(error::DetailsOf(status).retry_after_ms);
    absl::SleepFor(std::clamp<absl::Duration>(wait, kLeastPutOff, kMostPutOff));
  }
}

absl::StatusOr<v1::EditResult> TortureEditor::AwaitResult(uint64_t sequence) {
  while (true) {
    LATTICED_ASSIGN_OR_RETURN(const auto step, stream_->Next());
    if (step.ended()) return absl::UnavailableError("the server has ended a stream");
    if (step.update.has_value()) context_.model->Told(step.update->end.revision());
    if (step.result.has_value() && step.result->sequence() == sequence) return *step.result;
  }
}

void TortureEditor::CountReconnections() {
  const int now = stream_->reconnections();
  context_.counts->Reconnected(now - std::exchange(reconnections_, now));
}

}  // namespace latticed::client
