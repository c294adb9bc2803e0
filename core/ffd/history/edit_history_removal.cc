// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The removal of the lattice of an EditHistory.
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/history/edit_history.h"

namespace latticed {

// Undo and redo check for themselves whether their step may come.
absl::Status EditHistory::CheckPresent(const EditBatch& batch) const {
  const bool may = LoneEdit<Undo>(batch) != nullptr || LoneEdit<Redo>(batch) != nullptr ||
                   LoneEdit<ReplaceLattice>(batch) != nullptr ||
                   LoneEdit<SetWeights>(batch) != nullptr;
  return may || !absent() ? absl::OkStatus() : error::LatticeRemoved();
}

absl::Status EditHistory::TakeAway(const std::string& editor_id, const Rules& rules) {
  if (rules.admit_removal) LATTICED_RETURN_IF_ERROR(rules.admit_removal());
  CommitGestures("", "");
  ForgetUndone(editor_id);
  EditStep step = NewStep(editor_id);
  step.removes = true;
  Push(std::move(step));
  ++structure_id_;
  return absl::OkStatus();
}

// Whether the structure, or the absence of the lattice, may be what it is without the step.
absl::Status EditHistory::AdmitWithout(size_t position, const AdmitStructure& admit,
                                       const Rules& rules) const {
  const EditStep& step = layers_.steps()[position];
  if (!step.structural.has_value() && !step.removes) return absl::OkStatus();
  if (!layers_.AbsentWithout(position)) return admit(layers_.StructureWithout(position));
  return rules.admit_removal ? rules.admit_removal() : absl::OkStatus();
}

}  // namespace latticed
