// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/lattices/scene_history.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "fmt/format.h"

namespace latticed {

SceneHistory::SceneHistory(std::vector<Lattice> initial, double strength) {
  for (Lattice& lattice : initial) histories_.emplace_back(std::move(lattice), strength);
}

SceneHistory::SceneHistory(std::deque<EditHistory> histories) : histories_(std::move(histories)) {
  for (const EditHistory& history : histories_) {
    revision_ = std::max(revision_, history.revision());
    structure_id_ = std::max(structure_id_, history.structure_id());
  }
}

absl::StatusOr<SceneHistory> SceneHistory::FromImages(std::vector<EditHistoryImage> images) {
  std::deque<EditHistory> histories;
  for (EditHistoryImage& image : images) {
    LATTICED_ASSIGN_OR_RETURN(auto history, EditHistory::FromImage(std::move(image)));
    histories.push_back(std::move(history));
  }
  SceneHistory history(std::move(histories));
  if (history.structures().empty()) return absl::DataLossError("a scene has no lattice");
  return history;
}

std::vector<EditHistoryImage> SceneHistory::images() const {
  std::vector<EditHistoryImage> images;
  for (const EditHistory& history : histories_) images.push_back(history.image());
  return images;
}

absl::Status SceneHistory::Check(const EditBatch& batch) const {
  if (batch.lattice > 0 && SetsWeights(batch)) {
    return error::InvalidField("lattice", "weights are set by edits of lattice 0");
  }
  if (batch.lattice >= histories_.size() && !batch.refusal.ok()) return batch.refusal;
  if (IsFree(batch.lattice) && !batch.edits.empty() &&
      std::holds_alternative<ReplaceLattice>(batch.edits.front())) {
    return CheckAddition(batch);
  }
  return error::CheckRange("lattice", batch.lattice, 0, static_cast<double>(histories_.size()) - 1);
}

absl::Status SceneHistory::CheckAddition(const EditBatch& batch) const {
  constexpr char kField[] = "edits[0].replace_lattice";
  if (batch.lattice == static_cast<uint32_t>(limits::kMaxLattices)) {
    return error::InvalidField("lattice",
                               fmt::format("a scene has at most {} lattices", limits::kMaxLattices),
                               "OUT_OF_RANGE");
  }
  const auto* replace = LoneEdit<ReplaceLattice>(batch);
  return replace == nullptr ? NotAlone(kField) : absl::OkStatus();
}

bool SceneHistory::IsFree(uint32_t lattice) const {
  return lattice == histories_.size() ||
         (lattice < histories_.size() && histories_[lattice].absent());
}

size_t SceneHistory::NewestOf(std::string_view editor_id) const {
  size_t newest = 0;
  for (size_t k = 1; k < histories_.size(); ++k) {
    if (histories_[k].last_sequence(editor_id) > histories_[newest].last_sequence(editor_id)) {
      newest = k;
    }
  }
  return newest;
}

EditHistory SceneHistory::MadeFor(Lattice at_rest, bool absent) const {
  EditHistory history = absent ? EditHistory::Absent(at_rest) : EditHistory(std::move(at_rest));
  history.GoOnFrom(revision_, structure_id_);
  return history;
}

void SceneHistory::Add(EditHistory history) {
  histories_.push_back(std::move(history));
  last_ = histories_.size() - 1;
  GoOn();
}

void SceneHistory::TurnTo(size_t lattice) {
  last_ = lattice;
  histories_[last_].GoOnFrom(revision_, structure_id_);
}

void SceneHistory::GoOn() {
  revision_ = histories_[last_].revision();
  structure_id_ = histories_[last_].structure_id();
}

absl::StatusOr<EditOutcome> SceneHistory::Apply(const EditBatch& batch, TimePoint now,
                                                const AdmitStructure& admit,
                                                const AdmitPoints& admit_points,
                                                const VolumeKeeper* keeper,
                                                const AdmitWeights& admit_weights,
                                                const AdmitRemoval& admit_removal) {
  restored_.reset();
  auto outcome = ApplyToOne(batch, now, admit, admit_points, keeper, admit_weights, admit_removal);
  if (outcome.ok() && !outcome->repeated) outcome->also_moved = TakeFollowers(batch);
  return outcome;
}

absl::StatusOr<EditOutcome> SceneHistory::ApplyToOne(const EditBatch& batch, TimePoint now,
                                                     const AdmitStructure& admit,
                                                     const AdmitPoints& admit_points,
                                                     const VolumeKeeper* keeper,
                                                     const AdmitWeights& admit_weights,
                                                     const AdmitRemoval& admit_removal) {
  if (const size_t newest = NewestOf(batch.editor_id);
      histories_[newest].last_sequence(batch.editor_id) >= std::max<uint64_t>(batch.sequence, 1)) {
    // It gets its result there, or why it comes too late.
    return histories_[newest].Apply(batch, now, admit, admit_points, keeper, admit_weights,
                                    admit_removal);
  }
  // Not sooner: a batch that is sent again may have come when the lattice was there.
  const auto* replace = LoneEdit<ReplaceLattice>(batch);
  if (replace != nullptr && replace->keep_shape && IsFree(batch.lattice)) {
    const absl::Status refusal = error::InvalidField(
        "edits[0].replace_lattice.keep_shape", "a lattice that is added has no shape to keep");
    if (batch.lattice == histories_.size()) return refusal;
    EditBatch refused = batch;
    refused.refusal = refusal;
    TurnTo(batch.lattice);
    return histories_[last_].Apply(refused, now, admit);  // which keeps the result
  }
  if (batch.lattice == histories_.size()) {
    const LatticeStructure& structure = replace->lattice.structure;
    LATTICED_RETURN_IF_ERROR(Validate(structure));
    EditHistory added = MadeFor({structure, IdentityControlPoints(structure)}, true);
    auto outcome = added.Apply(batch, now, admit, admit_points, keeper, admit_weights);
    if (outcome.ok()) Add(std::move(added));
    return outcome;
  }
  TurnTo(batch.lattice);
  auto outcome = histories_[last_].Apply(batch, now, admit, admit_points, keeper, admit_weights,
                                         admit_removal);
  GoOn();
  return outcome;
}

void SceneHistory::SetTouched(const EditBatch& batch, uint64_t boxes, uint64_t patches) {
  histories_[batch.lattice].SetTouched(batch.editor_id, boxes, patches);
}

EditRecord SceneHistory::LastRecord(const EditBatch& batch, TimePoint now) const {
  const EditHistory& history = histories_[batch.lattice];
  EditRecord record = history.LastRecord(batch, now);
  record.adds = history.records() == 1 && history.began_absent();
  record.restored = restored_;
  return record;
}

absl::Status SceneHistory::ApplyRecord(const EditRecord& record) {
  if (!Check(record.batch).ok()) {
    return absl::DataLossError("the record is of a lattice that the scene does not have");
  }
  if (record.batch.lattice == histories_.size()) {
    if (!record.made.has_value()) return absl::DataLossError("the record adds no lattice");
    const LatticeStructure& structure = record.made->structure;
    LATTICED_RETURN_IF_ERROR(Validate(structure));
    // Earlier servers took a lattice to rest where its addition was undone.
    EditHistory added = MadeFor({structure, IdentityControlPoints(structure)}, record.adds);
    LATTICED_RETURN_IF_ERROR(added.ApplyRecord(record));
    Add(std::move(added));
  } else {
    TurnTo(record.batch.lattice);
    LATTICED_RETURN_IF_ERROR(histories_[last_].ApplyRecord(record));
    if (structures().empty()) return absl::DataLossError("the record removes the last lattice");
    GoOn();
  }
  if (!record.result.status.ok()) return absl::OkStatus();
  TakeFollowers(record.batch);
  if (!record.restored.has_value()) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(CheckRestored(record.batch, *record.restored));
  EditOutcome ignored;
  Restore(record.batch, *record.restored, ignored);
  return absl::OkStatus();
}

void SceneHistory::Restore(const EditBatch& batch, RestoredPoints restored, EditOutcome& outcome) {
  histories_[restored.lattice].AddFollower(
      batch.editor_id, {batch.lattice, histories_[batch.lattice].touched().made}, restored.moved);
  if (std::ranges::find(outcome.also_moved, restored.lattice) == outcome.also_moved.end()) {
    outcome.also_moved.push_back(restored.lattice);
  }
  restored_ = std::move(restored);
}

std::vector<uint32_t> SceneHistory::TakeFollowers(const EditBatch& batch) {
  std::vector<uint32_t> moved;
  const StepsTouched touched = histories_[batch.lattice].touched();
  for (uint32_t k = 0; k < histories_.size(); ++k) {
    if (k == batch.lattice) continue;
    EditHistory& other = histories_[k];
    bool has_moved = false;
    if (touched.ended != 0) has_moved = other.TakeFollower({batch.lattice, touched.ended}, "");
    if (touched.undone != 0) {
      has_moved = other.TakeFollower({batch.lattice, touched.undone}, batch.editor_id);
    }
    if (touched.redone != 0) {
      has_moved = other.RedoFollower({batch.lattice, touched.redone}, touched.made);
    } else if (touched.made != 0) {
      other.ForgetFollowers(batch.lattice, batch.editor_id);
    }
    if (has_moved) moved.push_back(k);
  }
  return moved;
}

absl::Status SceneHistory::CheckRestored(const EditBatch& batch,
                                         const RestoredPoints& restored) const {
  const auto& [lattice, moved] = restored;
  const bool is_other = lattice != batch.lattice && lattice < histories_.size() &&
                        !histories_[lattice].absent() && histories_[batch.lattice].touched().made;
  const bool ascend =
      std::ranges::adjacent_find(moved.indices, std::greater_equal<>()) == moved.indices.end();
  if (!is_other || !ascend || moved.indices.empty() ||
      moved.indices.back() >= histories_[lattice].lattice().control_points.size()) {
    return absl::DataLossError("the record restores a volume by points that there are not");
  }
  for (const Vec3d position : moved.positions) {
    if (!CheckControlPoint(position, "").ok()) {
      return absl::DataLossError("the record restores a volume by points out of range");
    }
  }
  return absl::OkStatus();
}

std::optional<std::vector<Vec3d>> SceneHistory::PointsBefore(const EditBatch& batch,
                                                             uint32_t lattice) const {
  if (lattice == batch.lattice || batch.lattice >= histories_.size()) return std::nullopt;
  const uint64_t step = histories_[batch.lattice].GestureStep(batch);
  if (step == 0) return std::nullopt;
  return histories_[lattice].PointsWithoutFollower({batch.lattice, step});
}

void SceneHistory::CommitIdleGestures(TimePoint now) {
  for (EditHistory& history : histories_) history.CommitIdleGestures(now);
}

bool SceneHistory::gesture_open() const {
  return std::ranges::any_of(histories_, &EditHistory::gesture_open);
}

uint64_t SceneHistory::records() const {
  uint64_t records = 0;
  for (const EditHistory& history : histories_) records += history.records();
  return records;
}

size_t SceneHistory::MemoryBytes() const {
  size_t bytes = 0;
  for (const EditHistory& history : histories_) bytes += history.MemoryBytes();
  return bytes;
}

std::map<uint32_t, LatticeStructure> SceneHistory::structures() const {
  std::map<uint32_t, LatticeStructure> structures;
  for (uint32_t k = 0; k < histories_.size(); ++k) {
    if (!histories_[k].absent()) structures.emplace(k, histories_[k].lattice().structure);
  }
  return structures;
}

const EditHistory& SceneHistory::first() const {
  return *std::ranges::find_if_not(histories_, &EditHistory::absent);
}

}  // namespace latticed
