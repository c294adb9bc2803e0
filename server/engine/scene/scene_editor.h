// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits of one scene: a batch and a state in, the next state and what it changes out.
//
//   Apply(batch) -> EditCommit {state, delta, dirty chunks}    or why the batch is refused
//                -> wants a plan: `wanted` says of what. Nothing has
//                   changed. The caller makes the plan without a lock and calls again with it.
//
// Errors   those of core/ffd/history/edit_history.h and fold_guard.h
// Threads  one at a time: the scene locks. Time is an argument.
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_EDITOR_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_EDITOR_H_

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/ffd/history/edit_history.h"
#include "server/engine/lattices/scene_history.h"
#include "server/engine/scene/edit_log.h"
#include "server/engine/scene/fold_guard.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

// What a plan of the scene's mesh depends on.
struct PlanKey {
  std::map<uint32_t, LatticeStructure> structures;  // of all lattices, by number
  VertexWeights weights;
  friend bool operator==(const PlanKey& a, const PlanKey& b) {
    return a.structures == b.structures && SameWeights(a.weights, b.weights);
  }
};

// A plan that edits lead to, or the status of making it. Of the state, only what follows
// from the plan is set.
struct PlanCandidate {
  PlanKey key;
  absl::StatusOr<SceneState> state;
};

// The effect of one batch.
struct EditCommit {
  EditSummary summary;
  std::shared_ptr<const SceneState> state;
  std::shared_ptr<const LatticeDelta> delta;
  bool structure_changed = false;
  bool constraints_changed = false;
  bool box_changed = false;     // the quantisation box is new
  std::vector<uint32_t> moved;  // control points of the plan; none if the structure has changed
  std::vector<uint32_t> dirty;  // chunks, ascending
};

class SceneEditor {
 public:
  using TimePoint = EditHistory::TimePoint;
  using Clock = std::function<absl::Time()>;

  // `watch_folds`: the summary of each batch that is applied has a report of folds.
  explicit SceneEditor(SceneHistory history, bool watch_folds = false)
      : history_(std::move(history)), watch_folds_(watch_folds) {}

  // The state that the history is at before any Apply. `planned` has what follows from the plan. Without a
  // box it gets the first box of a scene.
  [[nodiscard]] std::shared_ptr<const SceneState> FirstState(
      SceneState planned, absl::Time commit_time,
      const std::optional<QuantisationBox>& box = std::nullopt) const;
  // `before` is the newest state. An EditCommit without a state repeats the answer of an earlier batch.
  [[nodiscard]] absl::StatusOr<EditCommit> Apply(const EditBatch& batch, const SceneState& before,
                                                 std::optional<PlanCandidate>& candidate,
                                                 std::optional<PlanKey>& wanted, TimePoint now,
                                                 const Clock& clock);
  // Commits gestures that have been silent for too long. If that ends the last open gesture, returns the
  // newest state without it, at the same revision; else null.
  [[nodiscard]] std::shared_ptr<const SceneState> EndIdleGestures(const SceneState& newest,
                                                                  TimePoint now);

  uint64_t records() const { return history_.records(); }
  // As EditHistory::LastRecord.
  [[nodiscard]] EditRecord LastRecord(const EditBatch& batch, TimePoint now) const {
    return history_.LastRecord(batch, now);
  }
  const SceneHistory& history() const { return history_; }

  // The bytes of undo steps, of what is kept for replay, and of what is known of folds.
  size_t MemoryBytes() const { return history_.MemoryBytes() + folds_.MemoryBytes(); }
  bool ForgetOldestStep() { return history_.ForgetOldestStep(); }
  bool ForgetOldestEditor() { return history_.ForgetOldestEditor(); }

 private:
  // Sets points, strength and constraints of the lattice at a place, or of all but one, as the history has them.
  void TakeLattice(SceneState& state, size_t place) const;
  void TakeLattices(SceneState& state, size_t left_out) const;
  // Whether `points` of the lattice, which `map` takes to control points of the plan, may be the next ones.
  absl::Status AdmitPointsOf(bool refuse_folds, const SceneState& before,
                             const std::shared_ptr<const DeformPlan>& plan, const OutsideMap& map,
                             std::span<const Vec3d> points);
  absl::Status AdmitPlanned(bool refuse_folds, const SceneState& before,
                            const std::shared_ptr<const DeformPlan>& plan,
                            std::span<const Vec3d> control_points);
  // The same under the plan made for it: where the batch's lattice gets another structure or weights are set, and where the
  // lattice goes away or is.
  absl::Status AdmitReplaced(const EditBatch& batch, const SceneState& before, SceneState planned,
                             std::span<const Vec3d> points, double strength);
  absl::Status AdmitRemaining(bool refuse_folds, const SceneState& before, SceneState planned);
  // What the history did. `next`: the state before, or of the new plan.
  EditCommit Commit(const EditBatch& batch, const SceneState& before, SceneState next,
                    EditOutcome outcome, const Clock& clock);
  SceneState NextState(const EditBatch& batch, const SceneState& before, SceneState next,
                       bool structure_changed, absl::Time now) const;

  SceneHistory history_;
  bool watch_folds_;
  FoldGuard folds_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_EDITOR_H_
