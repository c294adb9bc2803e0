// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/scene_model.h"

#include <algorithm>
#include <utility>

#include "client/cpp/library/patches/lattice_from_proto.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

absl::StatusOr<EditOutcome> ApplyTo(EditHistory& history, const EditBatch& batch) {
  // No gestures are open, so that no time passes.
  return history.Apply(batch, {}, [](const LatticeStructure&) { return absl::OkStatus(); });
}

std::string NameOf(const EditBatch& batch) {
  return fmt::format("edit {} of editor {}", batch.sequence, batch.editor_id);
}

// How the lattice differs from the model's; empty if all bits are the same.
std::string Difference(const EditHistory& model, const v1::LatticeState& state) {
  if (state.structure_id() != model.structure_id()) {
    return fmt::format("has structure {}, not {}", state.structure_id(), model.structure_id());
  }
  const auto lattice = FromProto(state.lattice());
  if (!lattice.ok()) {
    return "has a lattice that is none: " + std::string(lattice.status().message());
  }
  const Lattice& expected = model.lattice();
  if (lattice->structure != expected.structure) return "has other knots";
  for (size_t i = 0; i < expected.control_points.size(); ++i) {
    const Vec3d is = lattice->control_points[i], must = expected.control_points[i];
    if (SameBits(is, must)) continue;
    return fmt::format("has control point {} at ({}, {}, {}), not ({}, {}, {})", i, is.x, is.y,
                       is.z, must.x, must.y, must.z);
  }
  return "";
}

}  // namespace

SceneModel::SceneModel(std::string scene, Lattice initial)
    : scene_(std::move(scene)), history_(std::move(initial)) {}

void SceneModel::Fail(uint64_t Faults::*kind, uint64_t count, uint64_t revision,
                      const std::string& what) {
  if (!faults_.what.empty()) return;
  faults_.*kind += count;
  faults_.what.push_back(fmt::format("scene {}, revision {}: {}", scene_, revision, what));
  state_.reset();
}

void SceneModel::Begin() {
  const MutexLock lock(&mutex_);
  ++begun_;
  ++waiting_;
}

void SceneModel::Acknowledged(EditBatch batch, const v1::EditResult& result) {
  const MutexLock lock(&mutex_);
  --waiting_;
  const uint64_t revision = result.revision();
  const std::string name = NameOf(batch);
  newest_ = std::max(newest_, revision);
  const auto [answer, is_new] =
      answers_.try_emplace(revision, Answer{std::move(batch), result.structure_id()});
  if (!is_new || revision <= history_.revision()) {
    const std::string other = is_new ? "another edit" : NameOf(answer->second.batch);
    Fail(&Faults::twice, 1, revision,
         fmt::format("was acknowledged for {}, and for {}", other, name));
  }
  Compare();
}

void SceneModel::Refused(EditBatch batch, bool unsure) {
  const MutexLock lock(&mutex_);
  --waiting_;
  if (unsure) {
    unsure_.push_back(std::move(batch));
  } else {
    --begun_;
  }
  Compare();
}

void SceneModel::Told(uint64_t revision) {
  const MutexLock lock(&mutex_);
  newest_ = std::max(newest_, revision);
}

void SceneModel::Gone(const absl::Status& status) {
  const MutexLock lock(&mutex_);
  Fail(&Faults::lost, newest_, newest_,
       fmt::format("was acknowledged or shown, but now the server says: {}",
                   std::string(status.message())));
}

uint64_t SceneModel::newest() const {
  const MutexLock lock(&mutex_);
  return newest_;
}

Faults SceneModel::faults() const {
  const MutexLock lock(&mutex_);
  return faults_;
}

void SceneModel::Check(uint64_t newest, const v1::LatticeState& state) {
  const MutexLock lock(&mutex_);
  const uint64_t revision = state.revision();
  if (revision < newest) {
    Fail(&Faults::lost, newest - revision, revision,
         fmt::format("is the newest, but revision {} was acknowledged or shown", newest));
  } else if (revision > begun_) {
    Fail(&Faults::doubled, revision - begun_, revision,
         fmt::format("is more than the {} edits that were sent", begun_));
  }
  newest_ = std::max(newest_, revision);
  if (!faults_.what.empty() || state_.has_value()) return;
  state_ = state;
  Compare();
}

void SceneModel::Compare() {
  if (!state_.has_value()) return;
  while (history_.revision() < state_->revision()) {
    if (!Advance()) return;
  }
  // An older one than the last that was compared was on its way while answers came.
  if (history_.revision() == state_->revision()) {
    const std::string difference = Difference(history_, *state_);
    if (!difference.empty()) Fail(&Faults::differing, 1, history_.revision(), difference);
  }
  state_.reset();
}

bool SceneModel::Advance() {
  const uint64_t revision = history_.revision() + 1;
  const auto next = answers_.find(revision);
  if (next == answers_.end()) {
    if (waiting_ > 0) return false;
    if (ApplyUnsure()) return true;
    Fail(&Faults::gaps, 1, revision, "is of no edit that was acknowledged");
    return false;
  }
  const Answer& answer = next->second;
  const auto applied = ApplyTo(history_, answer.batch);
  if (!applied.ok()) {
    Fail(&Faults::differing, 1, revision,
         fmt::format("{} was acknowledged, but must be refused: {}", NameOf(answer.batch),
                     std::string(applied.status().message())));
  } else if (history_.structure_id() != answer.structure_id) {
    Fail(&Faults::differing, 1, revision,
         fmt::format("was acknowledged with structure {}, not {}", answer.structure_id,
                     history_.structure_id()));
  }
  answers_.erase(next);
  return faults_.what.empty();
}

bool SceneModel::ApplyUnsure() {
  for (auto batch = unsure_.begin(); batch != unsure_.end(); ++batch) {
    if (!ApplyTo(history_, *batch).ok()) continue;
    unsure_.erase(batch);
    return true;
  }
  return false;
}

}  // namespace latticed::client
