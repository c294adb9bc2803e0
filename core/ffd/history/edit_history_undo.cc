// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Undo, redo, and what is forgotten of an EditHistory.
#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/history/edit_history.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::string_view DoneBy(const EditStep& later) {
  if (later.removes) return "removed the lattice";
  return later.follows.has_value()
             ? "edited another lattice, for which this one restored the volume"
             : "changed the same control points";
}

absl::Status Conflict(std::string_view what, const EditStep& later) {
  return error::WithDetails(
      absl::AbortedError(
          fmt::format("{}: editor '{}' has since {}", what, later.editor_id, DoneBy(later))),
      {.reason = "UNDO_CONFLICT", .metadata = {{"editor_id", later.editor_id}}});
}

}  // namespace

absl::Status EditHistory::UndoStep(std::string_view editor_id, UndoScope scope,
                                   const AdmitStructure& admit, const Rules& rules) {
  const auto& steps = layers_.steps();
  std::optional<size_t> found;
  for (size_t n = steps.size(); n-- > 0 && !found.has_value();) {
    const bool mine = scope == UndoScope::kScene || steps[n].editor_id == editor_id;
    if (mine && !steps[n].follows.has_value()) found = n;
  }
  if (!found.has_value()) {
    return error::FailedPrecondition(
        "NOTHING_TO_UNDO", scope == UndoScope::kMine ? "this editor has no step left to undo"
                                                     : "the lattice has no step left to undo");
  }
  for (size_t n = *found + 1; n < steps.size(); ++n) {
    const bool others = steps[n].editor_id != editor_id || steps[n].follows.has_value();
    if (others && steps[n].Overlaps(steps[*found])) {
      return Conflict("undo", steps[n]);
    }
  }
  LATTICED_RETURN_IF_ERROR(AdmitWithout(*found, admit, rules));
  const bool structural = steps[*found].structural.has_value() || steps[*found].removes;
  const bool weighs = steps[*found].weights.has_value();
  if (weighs) {
    const auto without = layers_.WeightsWithout(*found);
    LATTICED_RETURN_IF_ERROR(Admit(without.value_or(made_weights_), rules));
    CommitGestures("", "");
  }
  UndoneStep undone{layers_.Remove(*found), std::string(editor_id), ++clock_};
  touched_.undone = undone.step.id;
  if (structural || weighs) ++structure_id_;
  undone.step.Close(false);
  undone_bytes_ += undone.step.MemoryBytes();
  undone_.push_back(std::move(undone));
  return absl::OkStatus();
}

absl::Status EditHistory::RedoStep(std::string_view editor_id, Restructurer restructured,
                                   const Rules& rules, EditSummary& summary) {
  const auto found = std::find_if(undone_.rbegin(), undone_.rend(), [&](const UndoneStep& u) {
    return u.undone_by == editor_id && !u.step.follows.has_value();
  });
  if (found == undone_.rend()) {
    return error::FailedPrecondition("NOTHING_TO_REDO", "this editor has no undone step left");
  }
  for (const EditStep& step : layers_.steps()) {
    const bool others = step.editor_id != editor_id || step.follows.has_value();
    if (step.written_at > found->undone_at && others && step.Overlaps(found->step)) {
      return Conflict("redo", step);
    }
  }
  const auto position = std::next(found).base();
  const bool replaces = found->step.structural.has_value() && found->step.structural->replaces();
  const bool weighs_alone = found->step.weights.has_value() && found->step.indices.empty();
  if (absent() && !replaces && !weighs_alone) return error::LatticeRemoved();
  if (found->step.structural.has_value()) {
    StructureEdit edit = found->step.structural->edit;
    if (auto* replace = std::get_if<ReplaceLattice>(&edit)) {
      replace->lattice = {found->step.structural->structure, found->step.positions};
    }
    auto status = Restructure(found->step, std::move(edit), "edits[0].redo", restructured, summary);
    if (status.ok()) touched_.redone = TakeUndone(position).id;
    return status;
  }
  if (found->step.structure_step != layers_.structure_step()) {
    return error::Aborted("UNDO_CONFLICT", "redo: the structure of the lattice has since changed");
  }
  if (found->step.weights.has_value()) {
    LATTICED_RETURN_IF_ERROR(Admit(*found->step.weights, rules));
    CommitGestures("", "");
    ++structure_id_;
  }
  if (found->step.removes) {
    if (rules.admit_removal) LATTICED_RETURN_IF_ERROR(rules.admit_removal());
    CommitGestures("", "");
    ++structure_id_;
  }
  EditStep step = TakeUndone(position);
  step.written_at = ++clock_;
  touched_.redone = step.id;
  Push(std::move(step));
  return absl::OkStatus();
}

EditStep EditHistory::TakeUndone(std::deque<UndoneStep>::iterator position) {
  undone_bytes_ -= position->step.MemoryBytes();
  EditStep step = std::move(position->step);
  undone_.erase(position);
  return step;
}

void EditHistory::ForgetUndone(std::string_view editor_id) {
  std::erase_if(undone_, [&](const UndoneStep& undone) {
    if (undone.undone_by != editor_id) return false;
    undone_bytes_ -= undone.step.MemoryBytes();
    return true;
  });
}

void EditHistory::TrimHistory() {
  constexpr auto kSteps = static_cast<size_t>(limits::kMaxUndoSteps);
  while (!undone_.empty() && (undone_.size() > kSteps || UndoBytes() > limits::kMaxUndoBytes)) {
    TakeUndone(undone_.begin());
  }
  while (layers_.steps().size() > kSteps || layers_.MemoryBytes() > limits::kMaxUndoBytes) {
    layers_.FoldOldest();
  }
}

bool EditHistory::ForgetOldestStep() {
  if (!undone_.empty()) {
    TakeUndone(undone_.begin());
    return true;
  }
  if (layers_.steps().size() <= 1) return false;
  layers_.FoldOldest();
  return true;
}

}  // namespace latticed
