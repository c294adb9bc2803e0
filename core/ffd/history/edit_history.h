// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edited lattice of a scene. It applies batches and keeps the undo history.
//
// Gestures  The batches of one editor with one gesture_id are one undo step. Each update starts from the positions that
//           its points had when the gesture first touched them. The previous update's changes to other points are taken
//           back; changes by other editors to other points stay. Where two editors move the same point, the last write
//           counts. An editor has at most one open gesture. A batch without gesture_id or with another one commits it;
//           so does a change of this lattice's structure, and 60 s of silence. After a silence, an update continues the
//           same step if it can.
// Undo      A step is a layer over earlier steps, and undo takes one layer out (edit_layers.h): what others did since
//           then to other points stays. Undo is kAborted UNDO_CONFLICT, naming the editor, if another editor has since
//           written one of the step's points or changed the structure. Redo puts back what the caller last undid; a new
//           edit of the caller discards it.
// Strength  set_strength writes the scene's strength as others write points: in gestures too, and the last write counts.
// Weights   set_weights is a step that makes another plan: structure_id rises, and open gestures end. It moves only what restores
//           a kept volume. The structure stays, so that steps below and above it can be undone without it.
// Removal   remove_lattice is a step that keeps everything, but the lattice is away: structure_id rises, open gestures end, and
//           edits other than set_weights are refused until the removal is undone or replace_lattice puts another one there.
//           A history may begin without a lattice; its first replacement is then the first lattice.
// Keeping   Edits honour the constraints (constraints/constraints.h). set_constraints is a step that moves nothing. Undo and
//           redo restore points as they were written, and keep no volume: if others have moved since, the next edit
//           restores it. insert_knot and replace_lattice map the constraints to the new control points. Where the lattice keeps
//           its frame and knots, held points also stay where they are.
// Followers The volume may be restored after an edit of another lattice of the scene. That is a step here which follows the other
//           one (SceneHistory): undo and redo of this lattice pass it over. Steps below it whose points it moved cannot be undone
//           before it is, whoever made them: UNDO_CONFLICT.
// Replay    The last sequence of each of the last 1,024 editors is kept with its result. The same sequence again
//           returns this result, also if it is an error, and changes nothing. A lower one is kAborted OUT_OF_ORDER.
//           A batch without a usable editor_id or sequence is not kept: it has no key, and sequence 0 means "not set".
//
// Records   What a batch did can be taken as an EditRecord. A history that began with the same lattice and applies the
//           records in order has the same bits in everything: lattice, steps, undone steps, kept results, revisions.
//
// Errors    kInvalidArgument naming the field; kAborted OUT_OF_ORDER, STRUCTURE_CHANGED, REVISION_CHANGED,
//           UNDO_CONFLICT; kFailedPrecondition NOTHING_TO_UNDO, NOTHING_TO_REDO, LATTICE_REMOVED; those of VolumeKeeper. A
//           refused batch changes nothing but what is kept for replay.
// Threads   one thread at a time: the caller locks
#ifndef LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_H_
#define LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/ffd/constraints/point_freedom.h"
#include "core/ffd/constraints/volume_keeper.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/history/edit_history_image.h"
#include "core/ffd/history/edit_layers.h"
#include "core/ffd/history/edit_record.h"
#include "core/ffd/history/editor_ledger.h"

namespace latticed {

// What a batch did to the steps of a history, by their ids; 0: nothing.
struct StepsTouched {
  uint64_t made = 0;    // also again, as a gesture is by each update
  uint64_t ended = 0;   // taken out for good, or to be made again
  uint64_t undone = 0;  // by undo
  uint64_t redone = 0;  // the id that it had. `made` is the new one
};

struct EditOutcome {
  EditSummary summary;
  // Control points whose bits changed, ascending. Empty for a repeated batch, and for a change of structure, which
  // changes all of them.
  std::vector<uint32_t> changed;
  bool structure_changed = false;
  bool constraints_changed = false;
  bool strength_changed = false;
  bool repeated = false;             // the stored result of the same sequence; nothing was done
  std::vector<uint32_t> also_moved;  // other lattices of the scene: set by SceneHistory
};

class EditHistory {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  // The status by which AdmitStructure puts a batch off. Apply then returns it, changes nothing and keeps no result for
  // replay; the caller applies the batch again later.
  [[nodiscard]] static absl::Status PutOff();
  [[nodiscard]] static bool IsPutOff(const absl::Status& status);

  // `initial` must be valid, the strength 0 to 1. The history begins at revision 0 and structure_id 1.
  explicit EditHistory(Lattice initial, double strength = 1);
  // Begins without a lattice: `at_rest` is what undo leads to before the first replacement.
  [[nodiscard]] static EditHistory Absent(const Lattice& at_rest);
  // Goes on from an image. kDataLoss naming what cannot be: an image from a file may be anything.
  [[nodiscard]] static absl::StatusOr<EditHistory> FromImage(EditHistoryImage image);
  [[nodiscard]] EditHistoryImage image() const;

  // Tells the weights with which the scene was made, and how many vertices its mesh has. Without this, weights that are set
  // have no least number. kDataLoss if steps have weights of another number.
  [[nodiscard]] absl::Status MadeWith(VertexWeights weights, size_t vertices);

  // Applies the whole batch or nothing. On success the revision rises by one, even if no control point changed. A scene
  // makes the plan for another structure in `admit`, and asks for memory there. `admit_points` is asked about what moves
  // control points or sets weights, but not about undo, redo, cancelled gestures and insert_knot. `admit_weights` does for
  // weights what `admit` does for a structure, `admit_removal` where the lattice goes away. `keeper` restores volumes; null: none
  // is kept.
  [[nodiscard]] absl::StatusOr<EditOutcome> Apply(const EditBatch& batch, TimePoint now,
                                                  const AdmitStructure& admit,
                                                  const AdmitPoints& admit_points = {},
                                                  const VolumeKeeper* keeper = nullptr,
                                                  const AdmitWeights& admit_weights = {},
                                                  const AdmitRemoval& admit_removal = {});
  // Makes the next batch follow upon this revision and structure: those of a scene, whose other lattices have histories too.
  // Neither may be lower than it is.
  void GoOnFrom(uint64_t revision, uint64_t structure_id) {
    revision_ = revision;
    structure_id_ = structure_id;
  }
  // Adds to the kept result of the editor's last batch what only the scene can count.
  void SetTouched(std::string_view editor_id, uint64_t boxes, uint64_t patches);

  // The number of batches whose results were kept: each is one record.
  uint64_t records() const { return records_; }
  // What the last batch did, which was `batch` at `now` and raised records().
  [[nodiscard]] EditRecord LastRecord(const EditBatch& batch, TimePoint now) const;
  // Does what the record says, and counts it. kDataLoss if that is impossible here, or leads to another revision or
  // structure than the record says; the history is then of no use.
  [[nodiscard]] absl::Status ApplyRecord(const EditRecord& record);

  // What the last batch did that was applied.
  const StepsTouched& touched() const { return touched_; }
  // Followers of a step of another lattice. Adds one; takes it out, for good or until its step is redone by `undone_by`; brings
  // it back for a step that may have another id then; forgets those that would come back with steps that an editor undid.
  // All but the first find nothing where the lattice's structure has changed since, or the lattice is away. Return whether
  // points may have moved.
  void AddFollower(std::string_view editor_id, const FollowedStep& of, SetControlPoints moved);
  bool TakeFollower(const FollowedStep& of, std::string_view undone_by);
  bool RedoFollower(const FollowedStep& of, uint64_t step);
  void ForgetFollowers(uint32_t lattice, std::string_view undone_by);
  // The control points without it; nullopt where there is none.
  [[nodiscard]] std::optional<std::vector<Vec3d>> PointsWithoutFollower(
      const FollowedStep& of) const;
  // The step of the batch's gesture that the batch would make again; 0: none.
  [[nodiscard]] uint64_t GestureStep(const EditBatch& batch) const;

  // Commits gestures that have been silent for limits::kGestureTimeoutSeconds. Apply does so itself; call this from a
  // timer where gesture_open() matters. It makes no revision.
  void CommitIdleGestures(TimePoint now);
  bool gesture_open() const;

  // Whether the lattice is away.
  bool absent() const { return layers_.absent(); }
  // Whether it was away before all steps that can still be undone.
  bool began_absent() const { return layers_.base().absent; }
  const Lattice& lattice() const { return layers_.lattice(); }
  Lattice initial() const { return layers_.initial(); }
  const Constraints& constraints() const { return layers_.constraints(); }
  // How much of the lattice's deformation the scene takes.
  double strength() const { return layers_.strength(); }
  // Of the mesh's vertices; null: none.
  VertexWeights weights() const { return layers_.weights().value_or(made_weights_); }
  uint64_t revision() const { return revision_; }
  uint64_t structure_id() const { return structure_id_; }
  // The kept results, of the editor who was heard last first.
  const std::list<EditorLedger::Entry>& results() const { return ledger_.entries(); }
  // 0 for an editor that is not remembered.
  uint64_t last_sequence(std::string_view editor_id) const;
  size_t undo_steps() const { return layers_.steps().size(); }
  // The bytes of all steps, undone ones included, of replaced lattices, and of the results kept for replay.
  size_t MemoryBytes() const { return UndoBytes() + layers_.BaseBytes() + ledger_.MemoryBytes(); }
  // Frees memory: forgets the step that was undone longest ago, or else the oldest step, which can then no longer be
  // undone. Returns false where only the newest step is left.
  bool ForgetOldestStep();
  // Forgets the result kept for the editor that was silent longest. Returns false where only one
  // editor is left.
  bool ForgetOldestEditor() { return ledger_.ForgetOldest(); }

 private:
  explicit EditHistory(EditLayers layers);

  // How a structural edit changes the present lattice; `field` is its path.
  using Restructurer = absl::FunctionRef<absl::StatusOr<StructureChange>(const StructureEdit& edit,
                                                                         std::string_view field)>;

  // What a batch must honour. A record has honoured it, and may have written nothing: all that it named was held.
  struct Rules {
    const PointFreedom* freedom = nullptr;
    const VolumeKeeper* keeper = nullptr;
    AdmitPoints admit_points;
    AdmitWeights admit_weights;
    AdmitRemoval admit_removal;
    bool is_record = false;
  };
  // The freedom of points, made once for a structure and its constraints.
  struct KnownFreedom {
    uint64_t structure_id = 0;
    Constraints constraints;
    PointFreedom freedom;
  };

  absl::Status ApplyNew(const EditBatch& batch, TimePoint now, const Rules& rules,
                        const AdmitStructure& admit, Restructurer restructured,
                        EditSummary& summary);
  absl::Status CheckPreconditions(const EditBatch& batch) const;
  absl::Status Write(const EditBatch& batch, TimePoint now, const Rules& rules,
                     EditSummary& summary);
  absl::Status KeepVolume(const EditBatch& batch, const Rules& rules, EditTarget& target) const;
  // Lets the lattice that takes the place of the present one honour the constraints.
  absl::Status KeepIn(Lattice& replaced, const EditBatch& batch, const VolumeKeeper* keeper) const;
  // Those of a lattice that takes the place of the present one.
  Constraints ConstraintsIn(const LatticeStructure& replaced) const;
  absl::Status Constrain(const std::string& editor_id, const Constraints& constraints,
                         const Rules& rules);
  absl::Status TakeAway(const std::string& editor_id, const Rules& rules);
  absl::Status CheckPresent(const EditBatch& batch) const;
  absl::Status Weigh(const EditBatch& batch, const SetWeights& change, const Rules& rules);
  // Where the points go that restore the volume under weights that were admitted. A record has them.
  absl::StatusOr<EditTarget> UnderWeights(const EditBatch& batch, const Rules& rules) const;
  // Those of the newest step, which sets weights. All, if weights of many vertices are no step any more (TrimHistory).
  SetControlPoints PointsUnderWeights() const;
  absl::Status Admit(const VertexWeights& weights, const Rules& rules) const;
  const PointFreedom* Freedom();
  void WritePoints(const EditTarget& target, EditStep& step);
  absl::Status Restructure(EditStep step, StructureEdit edit, std::string_view field,
                           Restructurer restructured, EditSummary& summary);
  absl::Status UndoStep(std::string_view editor_id, UndoScope scope, const AdmitStructure& admit,
                        const Rules& rules);
  absl::Status AdmitWithout(size_t position, const AdmitStructure& admit, const Rules& rules) const;
  absl::Status RedoStep(std::string_view editor_id, Restructurer restructured, const Rules& rules,
                        EditSummary& summary);
  void Keep(const EditBatch& batch, const EditSummary& summary);
  size_t FindGesture(const EditBatch& batch) const;
  std::optional<size_t> FindFollower(const FollowedStep& of) const;
  bool IsOfPresentStructure(const EditStep& step) const {
    return !absent() && step.structure_step == layers_.structure_step();
  }
  void CommitGestures(std::string_view editor_id, std::string_view except_gesture);
  EditStep TakeUndone(std::deque<UndoneStep>::iterator position);
  void ForgetUndone(std::string_view editor_id);
  // A step that is written now and changes nothing yet. Takes two times of the clock.
  EditStep NewStep(const std::string& editor_id) {
    return {.id = ++clock_,
            .structure_step = layers_.structure_step(),
            .written_at = ++clock_,
            .editor_id = editor_id};
  }
  void Push(EditStep step) {
    touched_.made = step.id;
    layers_.Push(std::move(step));
  }
  void TrimHistory();
  size_t UndoBytes() const { return layers_.MemoryBytes() + undone_bytes_; }

  EditLayers layers_;
  std::deque<UndoneStep> undone_;
  size_t undone_bytes_ = 0;
  EditorLedger ledger_;
  std::shared_ptr<const KnownFreedom> freedom_;
  StepsTouched touched_;
  VertexWeights made_weights_;
  size_t vertices_ = 0;  // 0: not known
  uint64_t revision_ = 0;
  uint64_t structure_id_ = 1;
  uint64_t clock_ = 0;  // orders writes and undos
  uint64_t records_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_HISTORY_EDIT_HISTORY_H_
