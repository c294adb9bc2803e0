// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertex weights of an EditHistory.
#include <optional>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/history/edit_history.h"

namespace latticed {

absl::Status EditHistory::Weigh(const std::string& editor_id, const SetWeights& change,
                                const Rules& rules) {
  LATTICED_ASSIGN_OR_RETURN(VertexWeights weights,
                            Changed(this->weights(), change, vertices_, "edits[0].set_weights"));
  LATTICED_RETURN_IF_ERROR(Admit(weights, rules));
  CommitGestures("", "");
  ForgetUndone(editor_id);
  EditStep step = NewStep(editor_id);
  step.weights = std::move(weights);
  layers_.Push(std::move(step));
  ++structure_id_;
  return absl::OkStatus();
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
