// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/periodic_editor.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"

namespace latticed::client {

absl::StatusOr<std::unique_ptr<LoadEditor>> PeriodicEditor::Open(std::unique_ptr<Client> client,
                                                                 v1::WatchRequest request,
                                                                 const Context& context) {
  Client* const shared = client.get();
  std::string scene = request.scene();
  LATTICED_ASSIGN_OR_RETURN(auto watcher,
                            LoadWatcher::Open(std::move(client), std::move(request),
                                              {.decodes = context.decodes}, context.control));
  return std::unique_ptr<LoadEditor>(
      new PeriodicEditor(shared, std::move(scene), std::move(watcher), context));
}

PeriodicEditor::PeriodicEditor(Client* client, std::string scene,
                               std::unique_ptr<LoadWatcher> watcher, const Context& context)
    : client_(client),
      scene_(std::move(scene)),
      editor_id_(RandomEditorId()),
      watcher_(std::move(watcher)),
      context_(context) {}

void PeriodicEditor::Start(absl::Time begin) {
  const absl::Time first_due =
      begin + context_.plan->period * context_.number / context_.plan->editors;
  thread_ = std::thread([this, first_due] {
    absl::Status status = Edit(first_due);
    if (status.ok()) status = Commit();
    if (!status.ok()) context_.control->Fail(status);
    done_.Notify();
  });
}

void PeriodicEditor::Close() {
  if (thread_.joinable()) thread_.join();
  watcher_->Close();
}

absl::Status PeriodicEditor::Edit(absl::Time first_due) {
  const LoadPlan& plan = *context_.plan;
  const auto due_at = [&](uint64_t step) { return first_due + plan.period * step; };
  uint64_t step = 0;
  while (step < plan.edits && context_.control->SleepUntil(due_at(step))) {
    const uint64_t newest = plan.mode == LoadMode::kInterval ? NewestDue(step, first_due) : step;
    std::vector<absl::Time> due;
    for (; step <= newest; ++step) due.push_back(due_at(step));
    v1::EditBatch batch = MakeLoadEdit(*context_.lattice, plan.all_points, newest);
    LATTICED_RETURN_IF_ERROR(Apply(std::move(batch), newest, due));
  }
  if (step < plan.edits && context_.control->Stopped() && absl::Now() >= due_at(step)) {
    context_.edits->AddUnsent(NewestDue(step, first_due) - step + 1);
  }
  return absl::OkStatus();
}

uint64_t PeriodicEditor::NewestDue(uint64_t step, absl::Time first_due) const {
  const double periods = absl::FDivDuration(absl::Now() - first_due, context_.plan->period);
  return std::clamp(static_cast<uint64_t>(periods), step, context_.plan->edits - 1);
}

absl::Status PeriodicEditor::Apply(v1::EditBatch batch, uint64_t step,
                                   const std::vector<absl::Time>& due) {
  LATTICED_ASSIGN_OR_RETURN(const auto result, Send(std::move(batch), v1::GESTURE_PHASE_UPDATE));
  context_.edits->Add(due, context_.number, step, result);
  context_.control->CountEdits(due.size());
  return absl::OkStatus();
}

absl::Status PeriodicEditor::Commit() {
  if (context_.plan->mode != LoadMode::kInterval || sequence_ == 0) return absl::OkStatus();
  v1::EditBatch batch;
  batch.set_structure_id(context_.lattice->structure_id());
  return Send(std::move(batch), v1::GESTURE_PHASE_COMMIT).status();
}

absl::StatusOr<v1::EditResult> PeriodicEditor::Send(v1::EditBatch batch, v1::GesturePhase phase) {
  batch.set_scene(scene_);
  batch.set_editor_id(editor_id_);
  batch.set_sequence(++sequence_);
  if (context_.plan->mode == LoadMode::kInterval) {
    batch.set_gesture_id("load");
    batch.set_gesture_phase(phase);
  }
  return client_->ApplyEdits(batch);
}

}  // namespace latticed::client
