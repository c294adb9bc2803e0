// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An EditHistory as data: what its last batch did, and all that it holds.
#include <algorithm>
#include <functional>
#include <map>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "core/ffd/history/edit_history.h"
#include "fmt/format.h"

namespace latticed {
namespace {

absl::Status Impossible(std::string_view what) {
  return absl::DataLossError(fmt::format("the image of a scene's edits: {}", what));
}

// Structures by the id of the structural step that made them.
using Structures = std::map<uint64_t, const LatticeStructure*>;

bool ArePointsOf(const LatticeStructure& structure, const EditStep& step) {
  const auto count = static_cast<size_t>(structure.control_point_count());
  const bool ascend =
      std::ranges::adjacent_find(step.indices, std::greater_equal<>()) == step.indices.end();
  return ascend && (step.indices.empty() || step.indices.back() < count) &&
         (step.start.empty() || step.start.rbegin()->first < count);
}

bool AreWeights(const VertexWeights& weights) {
  return weights == nullptr ||
         std::ranges::all_of(*weights, [](float w) { return w >= 0 && w <= 1; });
}

// Whether it writes nothing but weights, or nothing at all, and has ended.
bool MovesNothing(const EditStep& step) {
  return !step.structural.has_value() && !step.constraints.has_value() &&
         !step.strength.has_value() && step.indices.empty() && step.positions.empty() &&
         step.start.empty() && !step.open && !step.timed_out;
}

absl::Status CheckStep(const EditStep& step, const Structures& structures) {
  if (step.removes && (step.weights.has_value() || !MovesNothing(step))) {
    return Impossible("a removal of the lattice does more");
  }
  if (step.strength.has_value()) {
    LATTICED_RETURN_IF_ERROR(CheckStrength(*step.strength, "a step's strength"));
  }
  if (step.weights.has_value() && !AreWeights(*step.weights)) return Impossible("a step's weights");
  if (step.structural.has_value()) {
    LATTICED_RETURN_IF_ERROR(Validate(Lattice{step.structural->structure, step.positions}));
    if (!step.constraints.has_value()) return absl::OkStatus();
    return latticed::Check(*step.constraints, step.structural->structure, "a step's constraints");
  }
  if (step.indices.size() != step.positions.size()) return Impossible("a step's points");
  // A step over a structure that is gone can never be redone.
  const auto structure = structures.find(step.structure_step);
  if (structure != structures.end() && !ArePointsOf(*structure->second, step)) {
    return Impossible("a step's indices");
  }
  if (structure != structures.end() && step.constraints.has_value()) {
    LATTICED_RETURN_IF_ERROR(
        latticed::Check(*step.constraints, *structure->second, "a step's constraints"));
  }
  for (const Vec3d& position : step.positions) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(position, "a step's position"));
  }
  for (const auto& [index, position] : step.start) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(position, "a gesture's start"));
  }
  return absl::OkStatus();
}

// Steps between the removal of the lattice and the replacement that ends its absence. Undo takes it that any other step
// has a lattice.
absl::Status CheckAbsence(const EditHistoryImage& image) {
  bool absent = image.base.absent, open = false;
  for (const EditStep& step : image.steps) {
    const bool replaces = step.structural.has_value() && step.structural->replaces();
    const bool weighs = step.weights.has_value() && !step.removes && MovesNothing(step);
    if (absent && !replaces && !weighs) return Impossible("a step of a lattice that was removed");
    if (step.removes && open) return Impossible("a removal of the lattice leaves a gesture open");
    open |= step.open || step.timed_out;
    absent = step.removes || (absent && !replaces);
  }
  return absl::OkStatus();
}

// Steps above a structural step must be of its structure.
absl::Status CheckOrder(const EditHistoryImage& image) {
  uint64_t structure_step = image.base.structure_step;
  for (const EditStep& step : image.steps) {
    if (step.structural.has_value()) {
      structure_step = step.id;
    } else if (step.structure_step != structure_step) {
      return Impossible("a step is of another structure than that below it");
    }
  }
  return absl::OkStatus();
}

absl::Status Check(const EditHistoryImage& image) {
  LATTICED_RETURN_IF_ERROR(Validate(image.base.base));
  LATTICED_RETURN_IF_ERROR(Validate(image.base.initial));
  LATTICED_RETURN_IF_ERROR(
      latticed::Check(image.base.constraints, image.base.base.structure, "the constraints"));
  LATTICED_RETURN_IF_ERROR(CheckStrength(image.base.strength, "the strength"));
  if (image.base.weights.has_value() && !AreWeights(*image.base.weights)) {
    return Impossible("the weights");
  }
  Structures structures{{image.base.structure_step, &image.base.base.structure}};
  const auto note = [&](const EditStep& step) {
    return !step.structural.has_value() ||
           structures.emplace(step.id, &step.structural->structure).second;
  };
  for (const EditStep& step : image.steps) {
    if (!note(step)) return Impossible("two structures have one id");
  }
  for (const UndoneStep& undone : image.undone) {
    if (!note(undone.step)) return Impossible("two structures have one id");
  }
  for (const EditStep& step : image.steps) {
    LATTICED_RETURN_IF_ERROR(CheckStep(step, structures));
  }
  for (const UndoneStep& undone : image.undone) {
    LATTICED_RETURN_IF_ERROR(CheckStep(undone.step, structures));
  }
  LATTICED_RETURN_IF_ERROR(CheckOrder(image));
  return CheckAbsence(image);
}

}  // namespace

EditHistoryImage EditHistory::image() const {
  EditHistoryImage image{.base = layers_.base(),
                         .steps = layers_.steps(),
                         .undone = {undone_.begin(), undone_.end()},
                         .revision = revision_,
                         .structure_id = structure_id_,
                         .clock = clock_,
                         .records = records_};
  for (auto entry = ledger_.entries().rbegin(); entry != ledger_.entries().rend(); ++entry) {
    image.results.push_back({entry->editor_id, entry->summary});
  }
  return image;
}

absl::StatusOr<EditHistory> EditHistory::FromImage(EditHistoryImage image) {
  if (const absl::Status status = Check(image); !status.ok()) return Impossible(status.ToString());
  EditHistory history(EditLayers(std::move(image.base), std::move(image.steps)));
  for (UndoneStep& undone : image.undone) {
    history.undone_bytes_ += undone.step.MemoryBytes();
    history.undone_.push_back(std::move(undone));
  }
  for (auto& [editor_id, summary] : image.results) {
    history.ledger_.Store(editor_id, std::move(summary));
  }
  history.revision_ = image.revision;
  history.structure_id_ = image.structure_id;
  history.clock_ = image.clock;
  history.records_ = image.records;
  return history;
}

EditRecord EditHistory::LastRecord(const EditBatch& batch, TimePoint now) const {
  EditRecord record{.now = now, .result = *ledger_.Find(batch.editor_id)};
  record.batch.lattice = batch.lattice;
  record.batch.editor_id = batch.editor_id;
  record.batch.sequence = batch.sequence;
  if (!record.result.status.ok()) return record;
  record.batch.structure_id = batch.structure_id;
  record.batch.gesture_id = batch.gesture_id;
  record.batch.gesture_phase = batch.gesture_phase;
  const bool restructured = record.result.structure_id != batch.structure_id;
  const EditStep* const redone =
      LoneEdit<Redo>(batch) != nullptr ? &layers_.steps().back() : nullptr;
  const bool made = restructured && LoneEdit<Undo>(batch) == nullptr && !SetsWeights(batch) &&
                    LoneEdit<RemoveLattice>(batch) == nullptr;
  if (made && (redone == nullptr || redone->structural.has_value())) record.made = lattice();
  if (const auto* replace = LoneEdit<ReplaceLattice>(batch); replace != nullptr) {
    record.batch.edits = {ReplaceLattice{.keep_shape = replace->keep_shape}};
  } else if (LoneEdit<Undo>(batch) || LoneEdit<Redo>(batch) || LoneEdit<InsertKnot>(batch) ||
             LoneEdit<SetConstraints>(batch) || LoneEdit<RemoveLattice>(batch)) {
    record.batch.edits = batch.edits;
  } else if (SetsWeights(batch)) {
    record.batch.edits = batch.edits;
    SetControlPoints moved = PointsUnderWeights();
    if (!moved.indices.empty()) record.batch.edits.push_back(std::move(moved));
  } else if (!batch.edits.empty()) {
    const EditStep& step = layers_.steps().back();
    record.batch.edits = {SetControlPoints{step.indices, step.positions}};
    if (step.strength.has_value()) record.batch.edits.push_back(SetStrength{*step.strength});
  }
  return record;
}

absl::Status EditHistory::ApplyRecord(const EditRecord& record) {
  EditBatch batch = record.batch;
  batch.refusal = record.result.status;
  const auto restructured = [&](const StructureEdit&,
                                std::string_view field) -> absl::StatusOr<StructureChange> {
    if (!record.made.has_value()) return error::InvalidField(field, "has no lattice in the record");
    LATTICED_RETURN_IF_ERROR(Validate(*record.made));
    return StructureChange{*record.made, record.result.drag_residual};
  };
  EditSummary summary;
  const auto status = ApplyNew(
      batch, record.now, {.is_record = true}, [](const auto&) { return absl::OkStatus(); },
      restructured, summary);
  if (status.ok()) ++revision_;
  if (status != record.result.status || revision_ != record.result.revision ||
      structure_id_ != record.result.structure_id) {
    return absl::DataLossError(
        fmt::format("the record of revision {} leads to revision {}, structure {}: {}",
                    record.result.revision, revision_, structure_id_, status.ToString()));
  }
  Keep(record.batch, record.result);
  // A damaged record may name four billion.
  for (uint32_t n = 0; n < record.steps_forgotten && ForgetOldestStep();) ++n;
  for (uint32_t n = 0; n < record.editors_forgotten && ForgetOldestEditor();) ++n;
  return absl::OkStatus();
}

}  // namespace latticed
