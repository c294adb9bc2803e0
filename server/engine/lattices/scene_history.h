// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edits of all lattices of a scene. Each lattice has an EditHistory, with editors, gestures, undo steps and constraints
// of its own. Revision and structure_id are the scene's: they count the batches and the structures of all lattices.
//
// Replay    an editor's sequences rise over all lattices: a batch that is sent twice gets its result, whichever lattice it names
// Adding    a replacement for a number that no lattice has, up to the one that follows the last, adds a lattice. Undo of the step
//           takes it away. A refused addition of a new number changes nothing, and no result of it is kept
// Removing  the history of a lattice that was removed stays, with its number, for undo and for another lattice there. The
//           caller's AdmitRemoval refuses to remove the last one
// Volume    a lattice may restore the volume that it keeps after an edit of another one: RestoredPoints. This is a step of its
//           history that comes and goes with the edit: by undo, redo, and updates and the end of a gesture
// Records   in the order of batches, whichever lattice they are of (EditBatch::lattice)
// Errors    those of EditHistory; kInvalidArgument, field "lattice", for one that the scene does not have
// Threads   one thread at a time: the caller locks
#ifndef LATTICED_SERVER_ENGINE_LATTICES_SCENE_HISTORY_H_
#define LATTICED_SERVER_ENGINE_LATTICES_SCENE_HISTORY_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/ffd/history/edit_history.h"

namespace latticed {

class SceneHistory {
 public:
  using TimePoint = EditHistory::TimePoint;

  // The lattices must be valid, and at least one, the strength of all 0 to 1. The history begins at revision 0 and
  // structure_id 1.
  explicit SceneHistory(std::vector<Lattice> initial, double strength = 1);
  // One image per lattice. kDataLoss naming what cannot be.
  [[nodiscard]] static absl::StatusOr<SceneHistory> FromImages(
      std::vector<EditHistoryImage> images);
  [[nodiscard]] std::vector<EditHistoryImage> images() const;

  // kInvalidArgument for a batch whose lattice does not exist and which does not add it. No other function takes it.
  [[nodiscard]] absl::Status Check(const EditBatch& batch) const;
  // As EditHistory, for the lattice that the batch names.
  [[nodiscard]] absl::StatusOr<EditOutcome> Apply(const EditBatch& batch, TimePoint now,
                                                  const AdmitStructure& admit,
                                                  const AdmitPoints& admit_points = {},
                                                  const VolumeKeeper* keeper = nullptr,
                                                  const AdmitWeights& admit_weights = {},
                                                  const AdmitRemoval& admit_removal = {});
  // As EditHistory::MadeWith. The weights of the mesh are in the history of the first lattice.
  [[nodiscard]] absl::Status MadeWith(const VertexWeights& weights, size_t vertices) {
    return histories_[0].MadeWith(weights, vertices);
  }
  VertexWeights weights() const { return histories_[0].weights(); }
  void SetTouched(const EditBatch& batch, uint64_t boxes, uint64_t patches);
  // Lets the batch, which was applied last, also move points of another lattice.
  void Restore(const EditBatch& batch, RestoredPoints restored, EditOutcome& outcome);
  // The control points of another lattice without what an earlier update of the batch's gesture moved there, which the batch
  // takes back; nullopt if there is nothing.
  [[nodiscard]] std::optional<std::vector<Vec3d>> PointsBefore(const EditBatch& batch,
                                                               uint32_t lattice) const;
  [[nodiscard]] EditRecord LastRecord(const EditBatch& batch, TimePoint now) const;
  [[nodiscard]] absl::Status ApplyRecord(const EditRecord& record);
  // Of all lattices.
  void CommitIdleGestures(TimePoint now);
  bool gesture_open() const;
  uint64_t records() const;
  uint64_t revision() const { return revision_; }
  uint64_t structure_id() const { return structure_id_; }
  size_t MemoryBytes() const;
  // Of the lattice of the last batch, whose record tells it. As EditHistory's.
  bool ForgetOldestStep() { return histories_[last_].ForgetOldestStep(); }
  bool ForgetOldestEditor() { return histories_[last_].ForgetOldestEditor(); }

  // How many numbers lattices have, or had.
  size_t size() const { return histories_.size(); }
  const EditHistory& of(size_t lattice) const { return histories_[lattice]; }
  // Of the lattices that are there, by number.
  [[nodiscard]] std::map<uint32_t, LatticeStructure> structures() const;
  // The lattice that is there with the lowest number.
  const EditHistory& first() const;

 private:
  explicit SceneHistory(std::deque<EditHistory> histories);
  // Whether a replacement that names a number that no lattice has may add one.
  absl::Status CheckAddition(const EditBatch& batch) const;
  // Whether no lattice has the number, and an edit may add one there.
  bool IsFree(uint32_t lattice) const;
  // The lattice of the editor's batch with the highest sequence.
  size_t NewestOf(std::string_view editor_id) const;
  // The history of a lattice that is to be added, before its first batch.
  EditHistory MadeFor(Lattice at_rest, bool absent) const;
  void Add(EditHistory history);
  absl::StatusOr<EditOutcome> ApplyToOne(const EditBatch& batch, TimePoint now,
                                         const AdmitStructure& admit,
                                         const AdmitPoints& admit_points,
                                         const VolumeKeeper* keeper,
                                         const AdmitWeights& admit_weights,
                                         const AdmitRemoval& admit_removal);
  // Lets steps of other lattices follow what the batch did to the steps of its own. Returns the lattices that moved.
  std::vector<uint32_t> TakeFollowers(const EditBatch& batch);
  // kDataLoss if a record cannot have restored this.
  absl::Status CheckRestored(const EditBatch& batch, const RestoredPoints& restored) const;
  // Lets the next batch, which is of this lattice, follow upon the scene's revision.
  void TurnTo(size_t lattice);
  void GoOn();

  std::deque<EditHistory> histories_;  // a vector would move them when one is added
  size_t last_ = 0;                    // whose batch was the last
  uint64_t revision_ = 0;
  uint64_t structure_id_ = 1;
  std::optional<RestoredPoints> restored_;  // by the last batch
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_LATTICES_SCENE_HISTORY_H_
