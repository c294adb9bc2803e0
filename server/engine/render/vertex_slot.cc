// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/vertex_slot.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/engine/scene.h"

namespace latticed {

absl::Status VertexSlot::Prepare(const SceneState& state, const ViewSpec& spec) {
  if (view_ != nullptr && structure_id_ == state.structure_id) return absl::OkStatus();
  view_.reset();
  LATTICED_ASSIGN_OR_RETURN(view_, state.target->CreateView(spec));
  structure_id_ = state.structure_id;
  return absl::OkStatus();
}

absl::Status VertexSlot::Evaluate(const SceneState& state, std::span<const uint32_t> chunks,
                                  DeformView::Between between) {
  if (chunks.empty()) return absl::OkStatus();
  return view_->EvaluateInParts(*state.control_points, state.box, chunks, between);
}

}  // namespace latticed
