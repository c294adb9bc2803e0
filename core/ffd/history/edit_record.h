// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one batch did to an EditHistory, as data. EditHistory::ApplyRecord leads to the same bits wherever it runs. The
// batch itself would not: another build may round a product or a drag differently.
//
// Threads  plain data
#ifndef LATTICED_CORE_FFD_HISTORY_EDIT_RECORD_H_
#define LATTICED_CORE_FFD_HISTORY_EDIT_RECORD_H_

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/history/editor_ledger.h"
#include "core/ffd/lattice.h"

namespace latticed {

// Control points of another lattice of the scene, which an edit moved to restore the volume that the lattice keeps.
struct RestoredPoints {
  uint32_t lattice = 0;
  SetControlPoints moved;  // ascending
};

struct EditRecord {
  // The batch, with one SetControlPoints of all that it wrote in place of its edits, and a SetStrength if it set one. Undo,
  // redo, removals and changes of structure stay, a replacement without its lattice. A refused batch has no edits.
  // expected_revision is not kept.
  EditBatch batch;
  std::chrono::steady_clock::time_point now;
  // Whether it adds the lattice to its scene, so that its undo takes it away again.
  bool adds = false;
  // The lattice that a change of structure made, also if undone before and redone.
  std::optional<Lattice> made;
  std::optional<RestoredPoints> restored;
  // The result that is kept for its editor.
  EditSummary result;
  // What was forgotten after it for want of memory, in this order.
  uint32_t steps_forgotten = 0;
  uint32_t editors_forgotten = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_HISTORY_EDIT_RECORD_H_
