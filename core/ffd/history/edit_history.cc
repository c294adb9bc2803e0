// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/history/edit_history.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/cord.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr size_t kNoStep = std::numeric_limits<size_t>::max();
constexpr char kPutOffUrl[] = "latticed/edit-put-off";

absl::Status CheckEditor(const EditBatch& batch) {
  if (batch.editor_id.empty() || batch.editor_id.size() > limits::kMaxEditorIdBytes) {
    return error::InvalidField(
        "editor_id", fmt::format("has {} bytes, 1 to {} are allowed", batch.editor_id.size(),
                                 limits::kMaxEditorIdBytes));
  }
  if (batch.sequence == 0) return error::InvalidField("sequence", "must be 1 or more");
  return absl::OkStatus();
}

bool InGesture(const EditBatch& batch) { return !batch.gesture_id.empty(); }
// The phase of a batch without a gesture is ignored.
bool Cancels(const EditBatch& batch) {
  return InGesture(batch) && batch.gesture_phase == GesturePhase::kCancel;
}
bool Commits(const EditBatch& batch) {
  return InGesture(batch) && batch.gesture_phase == GesturePhase::kCommit;
}

absl::Status CheckGesture(const EditBatch& batch) {
  if (batch.gesture_id.size() > limits::kMaxEditorIdBytes) {
    return error::InvalidField(
        "gesture_id", fmt::format("has {} bytes, at most {} are allowed", batch.gesture_id.size(),
                                  limits::kMaxEditorIdBytes));
  }
  if (Cancels(batch) && !batch.edits.empty()) {
    return error::InvalidField("edits", "must be empty where a gesture is cancelled");
  }
  if (batch.edits.empty() && !Cancels(batch) && !Commits(batch)) {
    return error::InvalidField("edits", "must not be empty but to commit or cancel a gesture");
  }
  return absl::OkStatus();
}

std::pair<std::optional<StructureEdit>, std::string_view> LoneStructureEdit(
    const EditBatch& batch) {
  if (const auto* insert = LoneEdit<InsertKnot>(batch)) return {*insert, "edits[0].insert_knot"};
  if (const auto* edit = LoneEdit<ReplaceLattice>(batch))
    return {*edit, "edits[0].replace_lattice"};
  return {};
}

}  // namespace

EditHistory::EditHistory(Lattice initial, double strength)
    : EditHistory(EditLayers(std::move(initial), strength)) {}

EditHistory EditHistory::Absent(const Lattice& at_rest) {
  LayersBase base{.base = at_rest, .initial = at_rest, .absent = true};
  return EditHistory(EditLayers(std::move(base), {}));
}

EditHistory::EditHistory(EditLayers layers)
    : layers_(std::move(layers)), ledger_(static_cast<size_t>(limits::kMaxEditorsRemembered)) {}

absl::Status EditHistory::PutOff() {
  absl::Status status(absl::StatusCode::kUnavailable, "the structure is not yet prepared");
  status.SetPayload(kPutOffUrl, absl::Cord());
  return status;
}

bool EditHistory::IsPutOff(const absl::Status& status) {
  return status.GetPayload(kPutOffUrl).has_value();
}

absl::StatusOr<EditOutcome> EditHistory::Apply(const EditBatch& batch, TimePoint now,
                                               const AdmitStructure& admit,
                                               const AdmitPoints& admit_points,
                                               const VolumeKeeper* keeper,
                                               const AdmitWeights& admit_weights,
                                               const AdmitRemoval& admit_removal) {
  LATTICED_RETURN_IF_ERROR(CheckEditor(batch));
  if (const EditSummary* last = ledger_.Find(batch.editor_id); last != nullptr) {
    if (batch.sequence == last->sequence) {
      if (!last->status.ok()) return last->status;
      return EditOutcome{.summary = *last, .repeated = true};
    }
    if (batch.sequence < last->sequence) {
      return error::Aborted("OUT_OF_ORDER",
                            fmt::format("sequence: got {}, this editor has sent {} already",
                                        batch.sequence, last->sequence));
    }
  }
  const std::vector<Vec3d> before = lattice().control_points;
  const uint64_t structure_before = structure_id_;
  const Constraints constraints_before = constraints();
  const double strength_before = strength();
  EditOutcome outcome;
  const bool replaces = LoneEdit<ReplaceLattice>(batch) != nullptr;
  const auto restructured = [&](const StructureEdit& edit,
                                std::string_view field) -> absl::StatusOr<StructureChange> {
    LATTICED_ASSIGN_OR_RETURN(auto change,
                              ChangeStructure(lattice(), edit, field, admit, constraints().mirror));
    if (replaces) LATTICED_RETURN_IF_ERROR(KeepIn(change.lattice, batch, keeper));
    if (replaces && admit_points) {
      LATTICED_RETURN_IF_ERROR(admit_points(change.lattice.structure, change.lattice.control_points,
                                            absent() ? 1 : strength()));
    }
    return change;
  };
  const Rules rules{.freedom = Freedom(),
                    .keeper = keeper,
                    .admit_points = admit_points,
                    .admit_weights = admit_weights,
                    .admit_removal = admit_removal};
  outcome.summary.status = ApplyNew(batch, now, rules, admit, restructured, outcome.summary);
  if (IsPutOff(outcome.summary.status)) return outcome.summary.status;
  if (outcome.summary.status.ok()) ++revision_;
  outcome.summary.sequence = batch.sequence;
  outcome.summary.revision = revision_;
  outcome.summary.structure_id = structure_id_;
  outcome.structure_changed = structure_id_ != structure_before;
  outcome.constraints_changed = constraints() != constraints_before;
  outcome.strength_changed = strength() != strength_before;
  if (!outcome.structure_changed) {
    const auto& after = lattice().control_points;
    for (size_t i = 0; i < after.size(); ++i) {
      if (SameBits(before[i], after[i])) continue;
      outcome.changed.push_back(static_cast<uint32_t>(i));
      outcome.summary.largest_move =
          std::max(outcome.summary.largest_move, Norm(after[i] - before[i]));
    }
  }
  Keep(batch, outcome.summary);
  if (!outcome.summary.status.ok()) return outcome.summary.status;
  return outcome;
}

void EditHistory::Keep(const EditBatch& batch, const EditSummary& summary) {
  ledger_.Store(batch.editor_id, summary);
  ++records_;
}

absl::Status EditHistory::ApplyNew(const EditBatch& batch, TimePoint now, const Rules& rules,
                                   const AdmitStructure& admit, Restructurer restructured,
                                   EditSummary& summary) {
  touched_ = {};
  CommitIdleGestures(now);
  if (!batch.refusal.ok()) return batch.refusal;
  LATTICED_RETURN_IF_ERROR(CheckPreconditions(batch));
  LATTICED_RETURN_IF_ERROR(CheckPresent(batch));
  absl::Status status;
  if (const Undo* undo = LoneEdit<Undo>(batch); undo != nullptr) {
    status = UndoStep(batch.editor_id, undo->scope, admit, rules);
  } else if (LoneEdit<Redo>(batch) != nullptr) {
    status = RedoStep(batch.editor_id, restructured, rules, summary);
  } else if (const auto [edit, field] = LoneStructureEdit(batch); edit.has_value()) {
    status =
        Restructure(EditStep{.editor_id = batch.editor_id}, *edit, field, restructured, summary);
    if (status.ok()) ForgetUndone(batch.editor_id);
  } else if (const auto* set = LoneEdit<SetConstraints>(batch); set != nullptr) {
    status = Constrain(batch.editor_id, set->constraints, rules);
  } else if (const auto* weigh = LoneEdit<SetWeights>(batch);
             weigh != nullptr || (rules.is_record && SetsWeights(batch))) {
    status = Weigh(batch, std::get<SetWeights>(batch.edits.front()), rules);
  } else if (LoneEdit<RemoveLattice>(batch) != nullptr) {
    status = TakeAway(batch.editor_id, rules);
  } else if (Cancels(batch)) {
    // A client may cancel a gesture whose first update it never sent. Nothing is taken back then.
    if (const size_t gesture = FindGesture(batch); gesture != kNoStep) {
      touched_.ended = layers_.Remove(gesture).id;
    }
  } else {
    status = Write(batch, now, rules, summary);
  }
  if (status.ok()) {
    CommitGestures(batch.editor_id, batch.gesture_id);
    TrimHistory();
  }
  return status;
}

absl::Status EditHistory::CheckPreconditions(const EditBatch& batch) const {
  LATTICED_RETURN_IF_ERROR(CheckGesture(batch));
  if (batch.structure_id != structure_id_) {
    return error::Aborted(
        "STRUCTURE_CHANGED",
        fmt::format("structure_id: got {}, the scene is at {}; read the lattice again",
                    batch.structure_id, structure_id_));
  }
  if (batch.expected_revision.has_value() && *batch.expected_revision != revision_) {
    return error::WithDetails(
        absl::AbortedError(fmt::format("expected_revision: got {}, the scene is at {}",
                                       *batch.expected_revision, revision_)),
        {.reason = "REVISION_CHANGED", .metadata = {{"revision", fmt::to_string(revision_)}}});
  }
  return absl::OkStatus();
}

absl::Status EditHistory::Write(const EditBatch& batch, TimePoint now, const Rules& rules,
                                EditSummary& summary) {
  const size_t gesture = FindGesture(batch);
  EditTarget target(lattice(), layers_.StrengthWithout(gesture));
  target.freedom = rules.freedom;
  if (gesture != kNoStep) {
    for (const auto& [index, position] : layers_.steps()[gesture].start) {
      target.lattice.control_points[index] = position;
    }
  }
  const auto initial_now = [this] { return initial(); };
  for (size_t n = 0; n < batch.edits.size(); ++n) {
    const auto* written = std::get_if<SetControlPoints>(&batch.edits[n]);
    if (rules.is_record && written != nullptr && written->indices.empty()) continue;
    const std::string field = fmt::format("edits[{}]", n);
    LATTICED_RETURN_IF_ERROR(ApplyEdit(batch.edits[n], initial_now, field, target));
  }
  if (batch.edits.empty()) {  // a commit alone: undone steps may still be redone
    if (gesture != kNoStep) layers_.Close(gesture, false);
    return absl::OkStatus();
  }
  LATTICED_RETURN_IF_ERROR(KeepVolume(batch, rules, target));
  if (rules.admit_points) {
    auto points = gesture == kNoStep ? lattice().control_points : layers_.PointsWithout(gesture);
    for (size_t i = 0; i < points.size(); ++i) {
      if (target.written[i]) points[i] = target.lattice.control_points[i];
    }
    LATTICED_RETURN_IF_ERROR(rules.admit_points(lattice().structure, points, target.strength));
  }
  summary.drag_residual = target.drag_residual;
  ForgetUndone(batch.editor_id);
  EditStep step;
  if (gesture != kNoStep) {
    step = layers_.Remove(gesture);
    touched_.ended = step.id;
  } else {
    step.id = ++clock_;
    step.structure_step = layers_.structure_step();
    step.editor_id = batch.editor_id;
    step.gesture_id = batch.gesture_id;
  }
  step.last_heard = now;
  step.open = InGesture(batch);
  step.timed_out = false;
  WritePoints(target, step);
  if (Commits(batch)) step.Close(false);
  Push(std::move(step));
  return absl::OkStatus();
}

void EditHistory::WritePoints(const EditTarget& target, EditStep& step) {
  const auto count = static_cast<size_t>(std::ranges::count(target.written, true));
  step.indices = {};  // new vectors: what a step takes is to follow from its points alone
  step.indices.reserve(count);
  step.positions = {};
  step.positions.reserve(count);
  step.written_at = ++clock_;
  step.strength.reset();
  if (target.strength_written) step.strength = target.strength;
  for (uint32_t i = 0; i < target.written.size(); ++i) {
    if (!target.written[i]) continue;
    step.indices.push_back(i);
    step.positions.push_back(target.lattice.control_points[i]);
    if (step.open) step.start.emplace(i, lattice().control_points[i]);
  }
}

// Changes the structure as a new step; also redoes a change. The lattice may have changed since that was undone, so the
// edit is applied to the present one.
absl::Status EditHistory::Restructure(EditStep step, StructureEdit edit, std::string_view field,
                                      Restructurer restructured, EditSummary& summary) {
  LATTICED_ASSIGN_OR_RETURN(auto change, restructured(edit, field));
  auto& [structure, control_points] = change.lattice;
  CommitGestures("", "");
  // Undone steps above this one name its id. They may be redone only if their indices mean the same as before.
  const bool same = step.structural.has_value() && step.structural->structure == structure;
  if (!same) step.id = ++clock_;
  step.written_at = ++clock_;
  step.positions = std::move(control_points);
  step.constraints = std::holds_alternative<ReplaceLattice>(edit)
                         ? ConstraintsIn(structure)
                         : AfterInsertion(constraints(), lattice().structure, structure);
  if (absent()) step.strength = 1;  // another lattice begins
  if (auto* replace = std::get_if<ReplaceLattice>(&edit)) replace->lattice = {};
  step.structural = {std::move(structure), std::move(edit)};
  ++structure_id_;
  summary.drag_residual = change.residual;
  Push(std::move(step));
  return absl::OkStatus();
}

size_t EditHistory::FindGesture(const EditBatch& batch) const {
  if (batch.gesture_id.empty()) return kNoStep;
  const auto& steps = layers_.steps();
  for (size_t n = steps.size(); n-- > 0;) {
    const EditStep& step = steps[n];
    if ((step.open || step.timed_out) && step.editor_id == batch.editor_id &&
        step.gesture_id == batch.gesture_id) {
      return n;
    }
  }
  return kNoStep;
}

uint64_t EditHistory::GestureStep(const EditBatch& batch) const {
  const size_t gesture = batch.edits.empty() ? kNoStep : FindGesture(batch);
  return gesture == kNoStep ? 0 : layers_.steps()[gesture].id;
}

// Commits the gestures of one editor, except one gesture. An empty editor_id means all editors.
void EditHistory::CommitGestures(std::string_view editor_id, std::string_view except_gesture) {
  for (size_t n = layers_.steps().size(); n-- > 0;) {
    const EditStep& step = layers_.steps()[n];
    if (!step.open && !step.timed_out) continue;  // few are; comparing names takes longer
    const bool named = editor_id.empty() || step.editor_id == editor_id;
    const bool excepted = !except_gesture.empty() && step.gesture_id == except_gesture;
    if (named && !excepted) layers_.Close(n, false);
  }
}

void EditHistory::CommitIdleGestures(TimePoint now) {
  for (size_t n = layers_.steps().size(); n-- > 0;) {
    const EditStep& step = layers_.steps()[n];
    if (!step.open ||
        now - step.last_heard < std::chrono::seconds(limits::kGestureTimeoutSeconds)) {
      continue;
    }
    layers_.Close(n, true);
  }
}

void EditHistory::SetTouched(std::string_view editor_id, uint64_t boxes, uint64_t patches) {
  EditSummary* summary = ledger_.Find(editor_id);
  if (summary == nullptr) return;
  summary->boxes_touched = boxes;
  summary->patches_touched = patches;
}

bool EditHistory::gesture_open() const {
  return std::any_of(layers_.steps().begin(), layers_.steps().end(),
                     [](const EditStep& step) { return step.open; });
}

uint64_t EditHistory::last_sequence(std::string_view editor_id) const {
  const EditSummary* summary = ledger_.Find(editor_id);
  return summary == nullptr ? 0 : summary->sequence;
}

}  // namespace latticed
