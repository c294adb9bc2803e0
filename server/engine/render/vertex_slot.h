// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertices of a view at one revision.
//
// A view has two: while one is encoded the other may be evaluated. The second is made when it is
// first wanted.
//
// Errors   kResourceExhausted, and what the backend says
// Threads  one at a time: the stage of SceneView that uses it, with no lock held
#ifndef LATTICED_SERVER_ENGINE_RENDER_VERTEX_SLOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_VERTEX_SLOT_H_

#include <cstdint>
#include <memory>
#include <span>

#include "absl/status/status.h"
#include "core/backend.h"

namespace latticed {

struct SceneState;  // server/engine/scene.h

class VertexSlot {
 public:
  // Makes the vertices for the state's structure, where they are not that already: then nothing is
  // evaluated yet. Those of another structure go first, so that old and new do not need memory
  // together.
  [[nodiscard]] absl::Status Prepare(const SceneState& state, const ViewSpec& spec);
  // Brings `chunks` to the state; `between` as DeformView::EvaluateInParts calls it. After a failure
  // the vertices are good for nothing: Reset.
  [[nodiscard]] absl::Status Evaluate(const SceneState& state, std::span<const uint32_t> chunks,
                                      DeformView::Between between);
  // Gives the memory back.
  void Reset() { view_.reset(); }

  // After Prepare.
  DeformView& view() { return *view_; }
  MemoryUse memory() const { return view_ == nullptr ? MemoryUse{} : view_->memory(); }

 private:
  std::unique_ptr<DeformView> view_;
  uint64_t structure_id_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_VERTEX_SLOT_H_
