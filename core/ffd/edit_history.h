// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edited lattice of a scene: batches in, lattice and undo history out.
//
// Gestures  batches of one editor with one gesture_id are one undo step. Each update starts from
//           the positions that its points had when the gesture first touched them, and what the
//           previous update did elsewhere is taken back; other editors' changes to other points
//           stay. The point that two editors hold belongs to who wrote last. An editor has one
//           gesture open: a batch without gesture_id or with another commits it, so does a change
//           of structure or 60 s of silence; an update after such a silence goes on with the same
//           step if it can.
// Undo      a step is a layer over those before it, and undo takes one layer out (edit_layers.h):
//           what others did meanwhile to other points stays. It is kAborted UNDO_CONFLICT, naming
//           the editor, if another editor has since written one of its points or changed the
//           structure. Redo puts back what the caller last undid; a new edit of the caller clears it.
// Replay    the last sequence of each of the last 1,024 editors is kept with its result: the same
//           sequence again returns that, a refusal included, and changes nothing; a lower one is
//           kAborted OUT_OF_ORDER. A batch with no usable editor_id or sequence is not kept: there
//           is no key to keep it under, and 0 is a sequence that was not set.
//
// Errors   kInvalidArgument naming the field; kAborted OUT_OF_ORDER, STRUCTURE_CHANGED,
//          REVISION_CHANGED, UNDO_CONFLICT; kFailedPrecondition NOTHING_TO_UNDO, NOTHING_TO_REDO. A
//          refused batch changes nothing but what is kept for replay.
// Threads  one at a time: the caller locks
#ifndef LATTICED_CORE_FFD_EDIT_HISTORY_H_
#define LATTICED_CORE_FFD_EDIT_HISTORY_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/edit_layers.h"
#include "core/ffd/editor_ledger.h"
#include "core/ffd/lattice_edit.h"

namespace latticed {

struct EditOutcome {
  EditSummary summary;
  // Control points whose bits changed, sorted; empty when the structure changed (all did) or
  // repeated.
  std::vector<uint32_t> changed;
  bool structure_changed = false;
  bool repeated = false;  // nothing was done: this is the stored result of the same sequence
};

class EditHistory {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  // Asked before a batch that changes the structure takes effect; an error refuses the batch. This
  // is where a scene makes its plan and asks for memory.
  using AdmitStructure = std::function<absl::Status(const LatticeStructure&)>;
  // The answer that puts the batch off. Apply then returns it, changes nothing and keeps no result
  // for replay; the caller applies the batch again later.
  [[nodiscard]] static absl::Status PutOff();
  [[nodiscard]] static bool IsPutOff(const absl::Status& status);

  // `initial` must be valid. Revision 0, structure_id 1.
  explicit EditHistory(Lattice initial);

  // Atomic. On success the revision is one higher, even where no control point changed.
  [[nodiscard]] absl::StatusOr<EditOutcome> Apply(const EditBatch& batch, TimePoint now,
                                                  const AdmitStructure& admit);
  // Completes the kept result of the editor's last batch with what only the scene can count.
  void SetTouched(std::string_view editor_id, uint64_t boxes, uint64_t patches);

  // Commits gestures silent for limits::kGestureTimeoutSeconds. Apply does so itself; call this
  // from a timer where gesture_open() matters. No revision is made.
  void CommitIdleGestures(TimePoint now);
  bool gesture_open() const;

  const Lattice& lattice() const { return layers_.lattice(); }
  const Lattice& initial() const { return initial_; }
  uint64_t revision() const { return revision_; }
  uint64_t structure_id() const { return structure_id_; }
  // 0 for an editor that is not remembered.
  uint64_t last_sequence(std::string_view editor_id) const;
  size_t undo_steps() const { return layers_.steps().size(); }
  // The bytes of all steps, undone ones included, and of the results kept for replay.
  size_t MemoryBytes() const { return UndoBytes() + ledger_.MemoryBytes(); }
  // Frees memory: forgets the step that was undone longest ago, else the oldest step, which then
  // cannot be undone. Returns false where only the newest step is left.
  bool ForgetOldestStep();
  // Forgets the result kept for the editor that was silent longest. Returns false where only one
  // editor is left.
  bool ForgetOldestEditor() { return ledger_.ForgetOldest(); }

 private:
  struct Undone {
    EditStep step;
    std::string undone_by;
    uint64_t undone_at = 0;
  };

  absl::Status ApplyNew(const EditBatch& batch, TimePoint now, const AdmitStructure& admit,
                        EditSummary& summary);
  absl::Status CheckPreconditions(const EditBatch& batch) const;
  absl::Status Write(const EditBatch& batch, TimePoint now, EditSummary& summary);
  void WritePoints(const EditTarget& target, EditStep& step);
  absl::Status Insert(EditStep step, const InsertKnot& edit, std::string_view field,
                      const AdmitStructure& admit);
  absl::Status UndoStep(std::string_view editor_id, UndoScope scope, const AdmitStructure& admit);
  absl::Status RedoStep(std::string_view editor_id, const AdmitStructure& admit);
  size_t FindGesture(const EditBatch& batch) const;
  void CommitGestures(std::string_view editor_id, std::string_view except_gesture);
  EditStep TakeUndone(std::deque<Undone>::iterator position);
  void ForgetUndone(std::string_view editor_id);
  void TrimHistory();
  size_t UndoBytes() const { return layers_.MemoryBytes() + undone_bytes_; }

  Lattice initial_;
  EditLayers layers_;
  std::deque<Undone> undone_;
  size_t undone_bytes_ = 0;
  EditorLedger ledger_;
  uint64_t revision_ = 0;
  uint64_t structure_id_ = 1;
  uint64_t clock_ = 0;  // orders writes and undos
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_HISTORY_H_
