// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/lattices/scene_history.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
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
  return SceneHistory(std::move(histories));
}

std::vector<EditHistoryImage> SceneHistory::images() const {
  std::vector<EditHistoryImage> images;
  for (const EditHistory& history : histories_) images.push_back(history.image());
  return images;
}

absl::Status SceneHistory::Check(const EditBatch& batch) const {
  if (batch.lattice > 0 && LoneEdit<SetWeights>(batch) != nullptr) {
    return error::InvalidField("lattice", "weights are set by edits of lattice 0");
  }
  if (batch.lattice >= histories_.size() && !batch.refusal.ok()) return batch.refusal;
  if (batch.lattice == histories_.size() && !batch.edits.empty() &&
      std::holds_alternative<ReplaceLattice>(batch.edits.front())) {
    return CheckAddition(batch);
  }
  return error::CheckRange("lattice", batch.lattice, 0, static_cast<double>(histories_.size()) - 1);
}

absl::Status SceneHistory::CheckAddition(const EditBatch& batch) const {
  constexpr char kField[] = "edits[0].replace_lattice";
  if (histories_.size() == static_cast<size_t>(limits::kMaxLattices)) {
    return error::InvalidField("lattice",
                               fmt::format("a scene has at most {} lattices", limits::kMaxLattices),
                               "OUT_OF_RANGE");
  }
  const auto* replace = LoneEdit<ReplaceLattice>(batch);
  if (replace == nullptr) return NotAlone(kField);
  if (!replace->keep_shape) return absl::OkStatus();
  return error::InvalidField(fmt::format("{}.keep_shape", kField),
                             "a lattice that is added has no shape to keep");
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

EditHistory SceneHistory::MadeAtRest(const LatticeStructure& structure) const {
  EditHistory history(Lattice{structure, IdentityControlPoints(structure)});
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
                                                const AdmitWeights& admit_weights) {
  if (const size_t newest = NewestOf(batch.editor_id);
      histories_[newest].last_sequence(batch.editor_id) >= std::max<uint64_t>(batch.sequence, 1)) {
    // It gets its result there, or why it comes too late.
    return histories_[newest].Apply(batch, now, admit, admit_points, keeper, admit_weights);
  }
  if (batch.lattice == histories_.size()) {
    const LatticeStructure& structure = LoneEdit<ReplaceLattice>(batch)->lattice.structure;
    LATTICED_RETURN_IF_ERROR(Validate(structure));
    EditHistory added = MadeAtRest(structure);
    auto outcome = added.Apply(batch, now, admit, admit_points, keeper, admit_weights);
    if (outcome.ok()) Add(std::move(added));
    return outcome;
  }
  TurnTo(batch.lattice);
  auto outcome = histories_[last_].Apply(batch, now, admit, admit_points, keeper, admit_weights);
  GoOn();
  return outcome;
}

void SceneHistory::SetTouched(const EditBatch& batch, uint64_t boxes, uint64_t patches) {
  histories_[batch.lattice].SetTouched(batch.editor_id, boxes, patches);
}

EditRecord SceneHistory::LastRecord(const EditBatch& batch, TimePoint now) const {
  return histories_[batch.lattice].LastRecord(batch, now);
}

absl::Status SceneHistory::ApplyRecord(const EditRecord& record) {
  if (!Check(record.batch).ok()) {
    return absl::DataLossError("the record is of a lattice that the scene does not have");
  }
  if (record.batch.lattice == histories_.size()) {
    if (!record.made.has_value()) return absl::DataLossError("the record adds no lattice");
    LATTICED_RETURN_IF_ERROR(Validate(record.made->structure));
    EditHistory added = MadeAtRest(record.made->structure);
    LATTICED_RETURN_IF_ERROR(added.ApplyRecord(record));
    Add(std::move(added));
    return absl::OkStatus();
  }
  TurnTo(record.batch.lattice);
  LATTICED_RETURN_IF_ERROR(histories_[last_].ApplyRecord(record));
  GoOn();
  return absl::OkStatus();
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

std::vector<LatticeStructure> SceneHistory::structures() const {
  std::vector<LatticeStructure> structures;
  for (const EditHistory& history : histories_) {
    structures.push_back(history.lattice().structure);
  }
  return structures;
}

}  // namespace latticed
