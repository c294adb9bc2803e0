// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertex weights of an EditHistory.
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/history/edit_history.h"

namespace latticed {

absl::Status EditHistory::Weigh(const EditBatch& batch, const SetWeights& change,
                                const Rules& rules) {
  LATTICED_ASSIGN_OR_RETURN(VertexWeights weights,
                            Changed(this->weights(), change, vertices_, "edits[0].set_weights"));
  LATTICED_RETURN_IF_ERROR(Admit(weights, rules));
  LATTICED_ASSIGN_OR_RETURN(const EditTarget target, UnderWeights(batch, rules));
  CommitGestures("", "");
  ForgetUndone(batch.editor_id);
  EditStep step = NewStep(batch.editor_id);
  step.weights = std::move(weights);
  WritePoints(target, step);
  Push(std::move(step));
  ++structure_id_;
  return absl::OkStatus();
}

absl::StatusOr<EditTarget> EditHistory::UnderWeights(const EditBatch& batch,
                                                     const Rules& rules) const {
  EditTarget target(lattice(), strength());
  if (absent()) {
    if (batch.keep_volume.has_value() || batch.edits.size() > 1) return error::LatticeRemoved();
    return target;
  }
  if (batch.edits.size() > 1) {
    const auto initial_now = [this] { return initial(); };
    LATTICED_RETURN_IF_ERROR(ApplyEdit(batch.edits[1], initial_now, "edits[1]", target));
  }
  LATTICED_RETURN_IF_ERROR(KeepVolume(batch, rules, target));
  if (rules.admit_points) {
    LATTICED_RETURN_IF_ERROR(rules.admit_points(target.lattice.structure,
                                                target.lattice.control_points, target.strength));
  }
  return target;
}

SetControlPoints EditHistory::PointsUnderWeights() const {
  if (!layers_.steps().empty() && layers_.steps().back().weights.has_value()) {
    return {layers_.steps().back().indices, layers_.steps().back().positions};
  }
  if (absent()) return {};
  SetControlPoints all{{}, lattice().control_points};
  all.indices.resize(all.positions.size());
  std::iota(all.indices.begin(), all.indices.end(), 0u);
  return all;
}

absl::Status EditHistory::Admit(const VertexWeights& weights, const Rules& rules) const {
  if (rules.is_record) return absl::OkStatus();
  return rules.admit_weights ? rules.admit_weights(weights) : absl::OkStatus();
}

absl::Status EditHistory::MadeWith(VertexWeights weights, size_t vertices) {
  const auto fits = [&](const std::optional<VertexWeights>& of) {
    return !of.has_value() || *of == nullptr || (*of)->size() == vertices;
  };
  bool all = fits(layers_.base().weights);
  for (const EditStep& step : layers_.steps()) all = all && fits(step.weights);
  for (const UndoneStep& undone : undone_) all = all && fits(undone.step.weights);
  if (!all) return absl::DataLossError("a step has weights of another number of vertices");
  made_weights_ = std::move(weights);
  vertices_ = vertices;
  return absl::OkStatus();
}

}  // namespace latticed
