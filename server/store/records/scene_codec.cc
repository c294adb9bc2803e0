// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/records/scene_codec.h"

#include <memory>
#include <utility>
#include <variant>

#include "absl/strings/cord.h"
#include "core/base/status_macros.h"
#include "server/store/records/constraints_codec.h"
#include "server/store/records/lattice_codec.h"

namespace latticed {
namespace {

using TimePoint = std::chrono::steady_clock::time_point;

int64_t ToStored(TimePoint time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}
// The difference of two such times fits in nanoseconds.
absl::StatusOr<TimePoint> TimeFromStored(int64_t nanoseconds) {
  constexpr std::chrono::nanoseconds kMost = std::chrono::hours(24 * 365 * 100);
  const std::chrono::nanoseconds time(nanoseconds);
  if (time < -kMost || time > kMost) return NotARecord("a time");
  return TimePoint(time);
}

void ToStored(const QuantisationBox& box, store::Box& stored) {
  stored.set_id(box.id);
  stored.set_x(box.origin.x);
  stored.set_y(box.origin.y);
  stored.set_z(box.origin.z);
  stored.set_range(box.range);
}
QuantisationBox FromStored(const store::Box& stored) {
  return {stored.id(), {stored.x(), stored.y(), stored.z()}, stored.range()};
}

void ToStored(const EditSummary& summary, store::Result& stored) {
  stored.set_sequence(summary.sequence);
  stored.set_revision(summary.revision);
  stored.set_structure_id(summary.structure_id);
  stored.set_boxes_touched(summary.boxes_touched);
  stored.set_patches_touched(summary.patches_touched);
  stored.set_largest_move(summary.largest_move);
  stored.set_drag_residual(summary.drag_residual);
  if (summary.status.ok()) return;
  stored.set_code(summary.status.raw_code());
  stored.set_message(std::string(summary.status.message()));
  summary.status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    store::Payload& item = *stored.add_payloads();
    item.set_url(std::string(url));
    item.set_value(std::string(payload));
  });
}
EditSummary FromStored(const store::Result& stored) {
  EditSummary summary{
      .sequence = stored.sequence(),
      .status = absl::Status(static_cast<absl::StatusCode>(stored.code()), stored.message()),
      .revision = stored.revision(),
      .structure_id = stored.structure_id(),
      .boxes_touched = stored.boxes_touched(),
      .patches_touched = stored.patches_touched(),
      .largest_move = stored.largest_move(),
      .drag_residual = stored.drag_residual()};
  for (const store::Payload& item : stored.payloads()) {
    summary.status.SetPayload(item.url(), absl::Cord(item.value()));
  }
  return summary;
}

void ToStored(const InsertKnot& insert, store::Edit& stored) {
  stored.mutable_insert_knot()->set_axis(static_cast<uint32_t>(insert.axis));
  stored.mutable_insert_knot()->set_value(insert.value);
}
void ToStored(const StructureEdit& edit, store::Edit& stored) {
  if (const auto* insert = std::get_if<InsertKnot>(&edit)) return ToStored(*insert, stored);
  stored.set_replace_keeps_shape(std::get<ReplaceLattice>(edit).keep_shape);
}
absl::StatusOr<StructureEdit> StructureEditFromStored(const store::Edit& stored) {
  if (stored.has_replace_keeps_shape()) {
    return ReplaceLattice{.keep_shape = stored.replace_keeps_shape()};
  }
  if (!stored.has_insert_knot() || stored.insert_knot().axis() > 2) {
    return NotARecord("a change of structure");
  }
  return InsertKnot{static_cast<int>(stored.insert_knot().axis()), stored.insert_knot().value()};
}

void ToStored(const std::vector<uint32_t>& indices, const std::vector<Vec3d>& positions,
              store::Points& stored) {
  stored.mutable_indices()->Add(indices.begin(), indices.end());
  ToStored(positions, *stored.mutable_positions());
}
absl::StatusOr<SetControlPoints> FromStored(const store::Points& stored) {
  SetControlPoints points{{stored.indices().begin(), stored.indices().end()}, {}};
  LATTICED_ASSIGN_OR_RETURN(points.positions, PointsFromStored(stored.positions()));
  if (points.positions.size() != points.indices.size()) return NotARecord("indices");
  return points;
}

void ToStored(const VertexWeights& weights, store::Weights& stored) {
  if (weights != nullptr) stored.mutable_values()->Add(weights->begin(), weights->end());
}
VertexWeights FromStored(const store::Weights& stored) {
  if (stored.values().empty()) return nullptr;
  return std::make_shared<const std::vector<float>>(stored.values().begin(), stored.values().end());
}

void ToStored(const Edit& edit, store::Record& stored) {
  if (const auto* written = std::get_if<SetControlPoints>(&edit)) {
    ToStored(written->indices, written->positions, *stored.mutable_written());
  } else if (const auto* strength = std::get_if<SetStrength>(&edit)) {
    stored.set_strength(strength->strength);
  } else if (const auto* undo = std::get_if<Undo>(&edit)) {
    stored.mutable_edit()->set_undo(static_cast<uint32_t>(undo->scope));
  } else if (std::holds_alternative<Redo>(edit)) {
    stored.mutable_edit()->set_redo(true);
  } else if (const auto* insert = std::get_if<InsertKnot>(&edit)) {
    ToStored(*insert, *stored.mutable_edit());
  } else if (const auto* weigh = std::get_if<SetWeights>(&edit)) {
    store::SetWeights& item = *stored.mutable_edit()->mutable_set_weights();
    item.mutable_indices()->Add(weigh->indices.begin(), weigh->indices.end());
    item.mutable_values()->Add(weigh->values.begin(), weigh->values.end());
  } else if (std::holds_alternative<RemoveLattice>(edit)) {
    stored.mutable_edit()->set_remove_lattice(true);
  } else if (const auto* set = std::get_if<SetConstraints>(&edit)) {
    ToStored(set->constraints, *stored.mutable_edit()->mutable_set_constraints());
  } else {
    stored.mutable_edit()->set_replace_keeps_shape(std::get<ReplaceLattice>(edit).keep_shape);
  }
}
void ToStored(const EditBatch& batch, store::Record& stored) {
  stored.set_lattice(batch.lattice);
  stored.set_editor_id(batch.editor_id);
  stored.set_sequence(batch.sequence);
  stored.set_structure_id(batch.structure_id);
  stored.set_gesture_id(batch.gesture_id);
  stored.set_gesture_phase(static_cast<uint32_t>(batch.gesture_phase));
  for (const Edit& edit : batch.edits) ToStored(edit, stored);
}
absl::StatusOr<Edit> FromStored(const store::Edit& stored) {
  if (stored.has_redo()) return Redo{};
  if (stored.has_remove_lattice()) return RemoveLattice{};
  if (stored.has_undo()) {
    if (stored.undo() > static_cast<uint32_t>(UndoScope::kScene)) return NotARecord("undo");
    return Undo{static_cast<UndoScope>(stored.undo())};
  }
  if (stored.has_set_constraints()) {
    LATTICED_ASSIGN_OR_RETURN(auto constraints, ConstraintsFromStored(stored.set_constraints()));
    return SetConstraints{std::move(constraints)};
  }
  if (stored.has_set_weights()) {
    const store::SetWeights& item = stored.set_weights();
    return SetWeights{{item.indices().begin(), item.indices().end()},
                      {item.values().begin(), item.values().end()}};
  }
  LATTICED_ASSIGN_OR_RETURN(const auto edit, StructureEditFromStored(stored));
  return std::visit([](const auto& e) -> Edit { return e; }, edit);
}
absl::StatusOr<EditBatch> BatchFromStored(const store::Record& stored) {
  if (stored.gesture_phase() > static_cast<uint32_t>(GesturePhase::kCancel)) {
    return NotARecord("the phase of a gesture");
  }
  EditBatch batch{.lattice = stored.lattice(),
                  .editor_id = stored.editor_id(),
                  .sequence = stored.sequence(),
                  .structure_id = stored.structure_id(),
                  .gesture_id = stored.gesture_id(),
                  .gesture_phase = static_cast<GesturePhase>(stored.gesture_phase())};
  if (stored.has_edit()) {
    LATTICED_ASSIGN_OR_RETURN(auto edit, FromStored(stored.edit()));
    batch.edits.push_back(std::move(edit));
  }
  if (stored.has_written()) {
    LATTICED_ASSIGN_OR_RETURN(auto written, FromStored(stored.written()));
    batch.edits.push_back(std::move(written));
    if (stored.has_strength()) batch.edits.push_back(SetStrength{stored.strength()});
  }
  if (batch.edits.size() > 2) return NotARecord("a batch of three edits");
  return batch;
}

void ToStored(const EditStep& step, store::Step& stored) {
  stored.set_id(step.id);
  stored.set_structure_step(step.structure_step);
  stored.set_written_at(step.written_at);
  stored.set_editor_id(step.editor_id);
  stored.set_gesture_id(step.gesture_id);
  stored.set_open(step.open);
  stored.set_timed_out(step.timed_out);
  stored.set_last_heard(ToStored(step.last_heard));
  for (const auto& [index, position] : step.start) {
    stored.mutable_start()->add_indices(index);
    for (int axis = 0; axis < 3; ++axis) stored.mutable_start()->add_positions(position[axis]);
  }
  if (step.strength.has_value()) stored.set_strength(*step.strength);
  if (step.weights.has_value()) ToStored(*step.weights, *stored.mutable_weights());
  stored.set_removes(step.removes);
  if (step.follows.has_value()) {
    stored.mutable_follows()->set_lattice(step.follows->lattice);
    stored.mutable_follows()->set_step(step.follows->step);
  }
  if (step.constraints.has_value()) ToStored(*step.constraints, *stored.mutable_constraints());
  if (!step.structural.has_value()) {
    return ToStored(step.indices, step.positions, *stored.mutable_points());
  }
  ToStored(Lattice{step.structural->structure, step.positions}, *stored.mutable_structure());
  ToStored(step.structural->edit, *stored.mutable_edit());
}
absl::StatusOr<EditStep> FromStored(const store::Step& stored) {
  EditStep step{.id = stored.id(),
                .structure_step = stored.structure_step(),
                .written_at = stored.written_at(),
                .editor_id = stored.editor_id(),
                .gesture_id = stored.gesture_id(),
                .open = stored.open(),
                .timed_out = stored.timed_out(),
                .removes = stored.removes()};
  LATTICED_ASSIGN_OR_RETURN(step.last_heard, TimeFromStored(stored.last_heard()));
  LATTICED_ASSIGN_OR_RETURN(const auto start, FromStored(stored.start()));
  for (size_t n = 0; n < start.indices.size(); ++n) {
    step.start.emplace(start.indices[n], start.positions[n]);
  }
  if (stored.has_constraints()) {
    LATTICED_ASSIGN_OR_RETURN(step.constraints, ConstraintsFromStored(stored.constraints()));
  }
  if (stored.has_strength()) step.strength = stored.strength();
  if (stored.has_follows()) {
    step.follows = FollowedStep{stored.follows().lattice(), stored.follows().step()};
  }
  if (stored.has_weights()) step.weights = FromStored(stored.weights());
  if (stored.has_structure()) {
    LATTICED_ASSIGN_OR_RETURN(auto lattice, LatticeFromStored(stored.structure()));
    LATTICED_ASSIGN_OR_RETURN(auto edit, StructureEditFromStored(stored.edit()));
    step.positions = std::move(lattice.control_points);
    step.structural = {std::move(lattice.structure), std::move(edit)};
    return step;
  }
  LATTICED_ASSIGN_OR_RETURN(auto points, FromStored(stored.points()));
  step.indices = std::move(points.indices);
  step.positions = std::move(points.positions);
  return step;
}

void ToStored(const EditHistoryImage& history, store::Image& stored) {
  ToStored(history.base.base, *stored.mutable_base());
  ToStored(history.base.initial, *stored.mutable_initial());
  stored.set_structure_step(history.base.structure_step);
  ToStored(history.base.constraints, *stored.mutable_constraints());
  stored.set_strength(history.base.strength);
  stored.set_absent(history.base.absent);
  if (history.base.weights.has_value()) {
    ToStored(*history.base.weights, *stored.mutable_weights());
  }
  for (const EditStep& step : history.steps) ToStored(step, *stored.add_steps());
  for (const UndoneStep& undone : history.undone) {
    store::UndoneStep& item = *stored.add_undone();
    ToStored(undone.step, *item.mutable_step());
    item.set_undone_by(undone.undone_by);
    item.set_undone_at(undone.undone_at);
  }
  for (const auto& [editor_id, summary] : history.results) {
    store::KeptResult& item = *stored.add_results();
    item.set_editor_id(editor_id);
    ToStored(summary, *item.mutable_result());
  }
  stored.set_revision(history.revision);
  stored.set_structure_id(history.structure_id);
  stored.set_clock(history.clock);
  stored.set_records(history.records);
}

absl::StatusOr<EditHistoryImage> HistoryFromStored(const store::Image& stored) {
  EditHistoryImage history;
  LATTICED_ASSIGN_OR_RETURN(history.base.base, LatticeFromStored(stored.base()));
  LATTICED_ASSIGN_OR_RETURN(history.base.initial, LatticeFromStored(stored.initial()));
  history.base.structure_step = stored.structure_step();
  LATTICED_ASSIGN_OR_RETURN(history.base.constraints, ConstraintsFromStored(stored.constraints()));
  if (stored.has_strength()) history.base.strength = stored.strength();
  history.base.absent = stored.absent();
  if (stored.has_weights()) history.base.weights = FromStored(stored.weights());
  for (const store::Step& item : stored.steps()) {
    LATTICED_ASSIGN_OR_RETURN(auto step, FromStored(item));
    history.steps.push_back(std::move(step));
  }
  for (const store::UndoneStep& item : stored.undone()) {
    LATTICED_ASSIGN_OR_RETURN(auto step, FromStored(item.step()));
    history.undone.push_back({std::move(step), item.undone_by(), item.undone_at()});
  }
  for (const store::KeptResult& item : stored.results()) {
    history.results.push_back({item.editor_id(), FromStored(item.result())});
  }
  history.revision = stored.revision();
  history.structure_id = stored.structure_id();
  history.clock = stored.clock();
  history.records = stored.records();
  return history;
}

}  // namespace

std::string EncodeRecord(const SceneRecord& record) {
  store::Record stored;
  ToStored(record.edit.batch, stored);
  stored.set_now(ToStored(record.edit.now));
  if (record.edit.made.has_value()) ToStored(*record.edit.made, *stored.mutable_made());
  ToStored(record.edit.result, *stored.mutable_result());
  stored.set_adds(record.edit.adds);
  if (const auto& restored = record.edit.restored; restored.has_value()) {
    stored.set_restorer(restored->lattice);
    ToStored(restored->moved.indices, restored->moved.positions, *stored.mutable_restored());
  }
  stored.set_steps_forgotten(record.edit.steps_forgotten);
  stored.set_editors_forgotten(record.edit.editors_forgotten);
  if (record.box.has_value()) ToStored(*record.box, *stored.mutable_box());
  stored.set_commit_time(absl::ToUnixNanos(record.commit_time));
  return stored.SerializeAsString();
}

absl::StatusOr<SceneRecord> DecodeRecord(std::string_view bytes) {
  store::Record stored;
  if (!stored.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return NotARecord("no such message");
  }
  SceneRecord record;
  LATTICED_ASSIGN_OR_RETURN(record.edit.batch, BatchFromStored(stored));
  LATTICED_ASSIGN_OR_RETURN(record.edit.now, TimeFromStored(stored.now()));
  if (stored.has_made()) {
    LATTICED_ASSIGN_OR_RETURN(record.edit.made, LatticeFromStored(stored.made()));
  }
  record.edit.result = FromStored(stored.result());
  record.edit.adds = stored.adds();
  if (stored.has_restored()) {
    LATTICED_ASSIGN_OR_RETURN(auto moved, FromStored(stored.restored()));
    record.edit.restored = {stored.restorer(), std::move(moved)};
  }
  record.edit.steps_forgotten = stored.steps_forgotten();
  record.edit.editors_forgotten = stored.editors_forgotten();
  if (stored.has_box()) record.box = FromStored(stored.box());
  record.commit_time = absl::FromUnixNanos(stored.commit_time());
  return record;
}

std::string EncodeImage(const SceneImage& image) {
  store::Image stored;
  ToStored(image.histories.front(), stored);
  for (size_t k = 1; k < image.histories.size(); ++k) {
    ToStored(image.histories[k], *stored.add_others());
  }
  ToStored(image.box, *stored.mutable_box());
  stored.set_now(ToStored(image.now));
  stored.set_commit_time(absl::ToUnixNanos(image.commit_time));
  return stored.SerializeAsString();
}

absl::StatusOr<SceneImage> DecodeImage(std::string_view bytes) {
  store::Image stored;
  if (!stored.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return NotARecord("no such message");
  }
  SceneImage image;
  LATTICED_ASSIGN_OR_RETURN(auto first, HistoryFromStored(stored));
  image.histories.push_back(std::move(first));
  for (const store::Image& item : stored.others()) {
    LATTICED_ASSIGN_OR_RETURN(auto history, HistoryFromStored(item));
    image.histories.push_back(std::move(history));
  }
  image.box = FromStored(stored.box());
  LATTICED_ASSIGN_OR_RETURN(image.now, TimeFromStored(stored.now()));
  image.commit_time = absl::FromUnixNanos(stored.commit_time());
  return image;
}

}  // namespace latticed
