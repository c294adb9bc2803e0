// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_editor.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <variant>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/dirty_set.h"
#include "server/engine/scene/volume_restorer.h"

namespace latticed {
namespace {

std::shared_ptr<LatticeDelta> MakeDelta(const EditBatch& batch, uint32_t number,
                                        const SceneState& state, bool strength_changed,
                                        std::vector<uint32_t> changed) {
  auto delta = std::make_shared<LatticeDelta>();
  delta->lattice = number;
  delta->revision = state.revision;
  delta->structure_id = state.structure_id;
  delta->editor_id = batch.editor_id;
  delta->sequence = batch.sequence;
  const size_t place = PlaceOf(state.lattices, number);
  if (place == state.lattices.size()) return delta;  // it was removed
  const SceneLattice& lattice = state.lattices[place];
  delta->positions.reserve(changed.size());
  if (strength_changed) delta->strength = lattice.map->strength();
  for (const uint32_t index : changed) delta->positions.push_back((*lattice.points)[index]);
  delta->indices = std::move(changed);
  return delta;
}

// Of points that both have, those that differ in any bit.
std::vector<uint32_t> ChangedPoints(const std::vector<Vec3d>& before,
                                    const std::vector<Vec3d>& after) {
  std::vector<uint32_t> changed;
  for (uint32_t i = 0; i < after.size(); ++i) {
    if (!SameBits(before[i], after[i])) changed.push_back(i);
  }
  return changed;
}

// Those of the batch's lattice, and of others that moved with it, by number. Where the structure has changed, of the first alone:
// watchers get whole lattices then.
std::shared_ptr<const LatticeDelta> MakeDeltas(const EditBatch& batch, const SceneState& before,
                                               const SceneState& state, EditOutcome& outcome) {
  auto own =
      MakeDelta(batch, batch.lattice, state, outcome.strength_changed, std::move(outcome.changed));
  if (outcome.structure_changed || outcome.also_moved.empty()) return own;
  std::vector<std::shared_ptr<LatticeDelta>> all{std::move(own)};
  for (const uint32_t number : outcome.also_moved) {
    const size_t place = PlaceOf(state.lattices, number);
    all.push_back(
        MakeDelta(batch, number, state, false,
                  ChangedPoints(*before.lattices[place].points, *state.lattices[place].points)));
  }
  std::ranges::sort(all, {}, [](const auto& delta) { return delta->lattice; });
  for (size_t n = all.size() - 1; n > 0; --n) all[n - 1]->also = all[n];
  return all.front();
}

// The control points of the plan that an edit moved. `changed`: those of the lattice.
std::vector<uint32_t> MovedByEdit(const SceneState& before, const SceneState& after,
                                  const std::vector<uint32_t>& changed) {
  if (after.lattices[0].map->is_identity() && before.lattices[0].map->is_identity()) {
    return changed;
  }
  return ChangedPoints(*before.control_points, *after.control_points);
}

// The batch, whose drags then aim at what this lattice must do beside the others. `map`: its own, with what they move.
EditBatch AmongOthers(EditBatch batch, const DeformPlan& plan, const OutsideMap& map) {
  std::vector<Vec3d> others;
  for (Edit& edit : batch.edits) {
    auto* const drag = std::get_if<DragPoints>(&edit);
    if (drag == nullptr) continue;
    if (others.empty()) others = map.Continue(IdentityControlPoints(map.structure()));
    for (size_t i = 0; i < std::min(drag->points.size(), drag->targets.size()); ++i) {
      const Vec3d point = drag->points[i];
      const double weight = drag->weights.empty() ? 1 : drag->weights[i];
      drag->targets[i] -= weight * (EvaluateWorld(plan, others, point).position - point);
    }
  }
  return batch;
}

constexpr size_t kNone = std::numeric_limits<size_t>::max();

}  // namespace

void SceneEditor::TakeLattice(SceneState& state, size_t place) const {
  const EditHistory& history = history_.of(state.lattices[place].number);
  TakePoints(state.lattices, place, history.strength(), history.lattice().control_points);
  auto& constraints = state.lattices[place].constraints;
  if (constraints != nullptr && *constraints == history.constraints()) return;
  constraints = std::make_shared<const Constraints>(history.constraints());
}

void SceneEditor::TakeLattices(SceneState& state, size_t left_out) const {
  for (size_t k = 0; k < state.lattices.size(); ++k) {
    if (k != left_out) TakeLattice(state, k);
  }
}

std::shared_ptr<const SceneState> SceneEditor::FirstState(
    SceneState planned, absl::Time commit_time, const std::optional<QuantisationBox>& box) const {
  planned.revision = history_.revision();
  planned.structure_id = history_.structure_id();
  TakeLattices(planned, kNone);
  planned.control_points = PlannedPoints(planned.lattices);
  const Bounds bounds = BoundsOf(planned);
  planned.box = box.has_value() ? *box : FitQuantisationBox(bounds, 1);
  // A box that was not made here, or by another build, may be too small.
  if (!planned.box.Contains(bounds)) planned.box = FitQuantisationBox(bounds, planned.box.id + 1);
  planned.commit_time = commit_time;
  planned.gesture_open = history_.gesture_open();
  return std::make_shared<const SceneState>(std::move(planned));
}

absl::StatusOr<EditCommit> SceneEditor::Apply(const EditBatch& batch, const SceneState& before,
                                              std::optional<PlanCandidate>& candidate,
                                              std::optional<PlanKey>& wanted, TimePoint now,
                                              const Clock& clock) {
  LATTICED_RETURN_IF_ERROR(history_.Check(batch));
  const size_t place = PlaceOf(before.lattices, batch.lattice);
  const bool absent = place == before.lattices.size();
  const auto plan = [&](PlanKey key) -> absl::Status {
    if (candidate && candidate->key == key) return candidate->state.status();
    wanted = std::move(key);
    return EditHistory::PutOff();
  };
  const auto admit = [&](const LatticeStructure& structure) {
    auto structures = history_.structures();
    structures[batch.lattice] = structure;
    return plan({std::move(structures), history_.weights()});
  };
  const std::optional<SceneState> unrestored = WithoutRestored(batch, before, history_);
  const SceneState& base = unrestored.has_value() ? *unrestored : before;
  const std::optional<uint32_t> restorer = RestorerOf(batch, base);
  std::optional<RestoredPoints> restored;
  // `planned`: as the batch alone leaves the lattices.
  const auto restore = [&](SceneState planned) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(restored, RestoreVolume(*restorer, history_, planned));
    return AdmitPlanned(batch.refuse_folds, before, planned.plan, *PlannedPoints(planned.lattices));
  };
  // Where no lattice's points are asked about: all lattices are as the history has them.
  const auto admit_others = [&]() -> absl::Status {
    if (!restorer.has_value()) return AdmitRemaining(batch.refuse_folds, before, *candidate->state);
    SceneState planned = *candidate->state;
    TakeLattices(planned, kNone);
    return restore(std::move(planned));
  };
  const auto admit_weights = [&](const VertexWeights& weights) -> absl::Status {
    LATTICED_RETURN_IF_ERROR(plan({history_.structures(), weights}));
    // The points of lattice 0 are asked about below, if there are any.
    if (!absent || LoneEdit<SetWeights>(batch) == nullptr) return absl::OkStatus();
    return admit_others();
  };
  const auto admit_removal = [&]() -> absl::Status {
    auto structures = history_.structures();
    structures.erase(batch.lattice);
    if (structures.empty()) {
      return error::FailedPrecondition("LAST_LATTICE", "lattice: a scene's last one cannot go");
    }
    LATTICED_RETURN_IF_ERROR(plan({std::move(structures), history_.weights()}));
    if (LoneEdit<RemoveLattice>(batch) == nullptr) return absl::OkStatus();
    return admit_others();
  };
  const auto map = MapAmongOthers(base.lattices, absent ? 0 : place);
  AdmitPoints admit_points;
  if (batch.refuse_folds || !map->is_identity() || candidate.has_value()) {
    admit_points = [&](const LatticeStructure& structure, std::span<const Vec3d> points,
                       double strength) {
      if (restorer.has_value()) {
        const bool replaced = absent || SetsWeights(batch) || structure != map->structure();
        SceneState planned = replaced ? *candidate->state : base;
        const size_t own = PlaceOf(planned.lattices, batch.lattice);
        if (replaced) TakeLattices(planned, own);
        TakePoints(planned.lattices, own, strength, {points.begin(), points.end()});
        return restore(std::move(planned));
      }
      // Weights make another surface of the same structures.
      if (!absent && !SetsWeights(batch) && structure == map->structure()) {
        return AdmitPointsOf(batch.refuse_folds, before, before.plan, *WithStrength(map, strength),
                             points);
      }
      return AdmitReplaced(batch, before, *candidate->state, points, strength);
    };
  }
  // The plan of new weights, or of another structure, is admitted before the volume is restored.
  const LazyVolumeKeeper keeper([&] {
    if (LoneEdit<ReplaceLattice>(batch) != nullptr) {
      SceneState planned = *candidate->state;
      const size_t own = PlaceOf(planned.lattices, batch.lattice);
      TakeLattices(planned, own);
      return SceneVolumeKeeper(planned.measures, MapAmongOthers(planned.lattices, own));
    }
    return SceneVolumeKeeper(SetsWeights(batch) ? candidate->state->measures : before.measures,
                             map);
  });
  std::optional<EditBatch> among_others;
  if (before.lattices.size() > 1) among_others = AmongOthers(batch, *before.plan, *map);
  auto outcome = history_.Apply(among_others.has_value() ? *among_others : batch, now, admit,
                                admit_points, &keeper, admit_weights, admit_removal);
  if (!outcome.ok()) return outcome.status();
  if (outcome->repeated) {
    if (!outcome->summary.status.ok()) return outcome->summary.status;
    return EditCommit{.summary = outcome->summary};
  }
  if (restored.has_value() && !restored->moved.indices.empty()) {
    history_.Restore(batch, *std::move(restored), *outcome);
  }
  if (!outcome->structure_changed) {
    if (absent) return absl::InternalError("an edit of a lattice that the scene does not have");
    return Commit(batch, before, SceneState(before), *std::move(outcome), clock);
  }
  return Commit(batch, before, *std::move(candidate->state), *std::move(outcome), clock);
}

EditCommit SceneEditor::Commit(const EditBatch& batch, const SceneState& before, SceneState next,
                               EditOutcome outcome, const Clock& clock) {
  EditCommit commit{.summary = std::move(outcome.summary),
                    .structure_changed = outcome.structure_changed,
                    .constraints_changed = outcome.constraints_changed};
  if (commit.structure_changed) {
    TakeLattices(next, kNone);
  } else {
    TakeLattice(next, PlaceOf(before.lattices, batch.lattice));
    for (const uint32_t number : outcome.also_moved) {
      TakeLattice(next, PlaceOf(before.lattices, number));
    }
  }
  next.control_points = PlannedPoints(next.lattices);
  if (!commit.structure_changed) commit.moved = MovedByEdit(before, next, outcome.changed);
  DirtySet dirty = commit.structure_changed ? AllDirty(*next.plan)
                                            : DirtyByControlPoints(*next.plan, commit.moved);
  history_.SetTouched(batch, dirty.boxes, dirty.patches);
  commit.summary.boxes_touched = dirty.boxes;
  commit.summary.patches_touched = next.patches_touched = dirty.patches;
  commit.dirty = std::move(dirty.chunks);
  // NextState takes the commit time. It is called late, because finding the dirty chunks takes a while.
  next = NextState(batch, before, std::move(next), commit.structure_changed, clock());
  commit.box_changed = next.box.id != before.box.id;
  if (watch_folds_ || batch.refuse_folds) {
    auto folds = folds_.Follow(before, next, commit.moved);
    if (watch_folds_) commit.summary.folds = std::move(folds);
  }
  commit.delta = MakeDeltas(batch, before, next, outcome);
  commit.state = std::make_shared<const SceneState>(std::move(next));
  return commit;
}

absl::Status SceneEditor::AdmitReplaced(const EditBatch& batch, const SceneState& before,
                                        SceneState planned, std::span<const Vec3d> points,
                                        double strength) {
  const size_t own = PlaceOf(planned.lattices, batch.lattice);
  TakeLattices(planned, own);
  const auto next = WithStrength(MapAmongOthers(planned.lattices, own), strength);
  return AdmitPointsOf(batch.refuse_folds, before, planned.plan, *next, points);
}

absl::Status SceneEditor::AdmitRemaining(bool refuse_folds, const SceneState& before,
                                         SceneState planned) {
  TakeLattices(planned, kNone);
  return AdmitPointsOf(refuse_folds, before, planned.plan, *MapAmongOthers(planned.lattices, 0),
                       *planned.lattices[0].points);
}

absl::Status SceneEditor::AdmitPointsOf(bool refuse_folds, const SceneState& before,
                                        const std::shared_ptr<const DeformPlan>& plan,
                                        const OutsideMap& map, std::span<const Vec3d> points) {
  if (map.is_identity()) {
    return refuse_folds ? folds_.Admit(before, plan, points) : absl::OkStatus();
  }
  return AdmitPlanned(refuse_folds, before, plan, map.Continue(points));
}

absl::Status SceneEditor::AdmitPlanned(bool refuse_folds, const SceneState& before,
                                       const std::shared_ptr<const DeformPlan>& plan,
                                       std::span<const Vec3d> control_points) {
  for (const Vec3d point : control_points) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(point, "lattice.outside"));
  }
  return refuse_folds ? folds_.Admit(before, plan, control_points) : absl::OkStatus();
}

SceneState SceneEditor::NextState(const EditBatch& batch, const SceneState& before, SceneState next,
                                  bool structure_changed, absl::Time now) const {
  next.revision = history_.revision();
  next.structure_id = history_.structure_id();
  next.commit_time = now;
  next.gesture_open = history_.gesture_open();
  const bool ends_gesture = !batch.gesture_id.empty() &&
                            batch.gesture_phase != GesturePhase::kUpdate && !next.gesture_open;
  next.busy_until = ends_gesture ? now : BusyUntil(before.commit_time, now);
  next.box =
      NextQuantisationBox(before.box, BoundsOf(next), next.gesture_open).value_or(before.box);
  // A new plan may move the origin of float32 vertices, and one box id must never name two origins.
  if (structure_changed) next.box.id = before.box.id + 1;
  return next;
}

std::shared_ptr<const SceneState> SceneEditor::EndIdleGestures(const SceneState& newest,
                                                               TimePoint now) {
  history_.CommitIdleGestures(now);
  if (!newest.gesture_open || history_.gesture_open()) return nullptr;
  auto state = std::make_shared<SceneState>(newest);
  state->gesture_open = false;
  return state;
}

}  // namespace latticed
