// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks that edits touched since the last update.
//
// Control point (i,j,k) influences the boxes whose spans are in i … i+nu, j … j+nv, k … k+nw. Dirty
// are the chunks of patches in those boxes, and of patches elsewhere with a vertex or edge owned by
// one of them: re-evaluating the owner can change the last bits of points that the edit cannot
// move.
//
// Threads  plain data: one owner at a time
#ifndef LATTICED_CORE_FFD_DIRTY_SET_H_
#define LATTICED_CORE_FFD_DIRTY_SET_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/ffd/deform_plan.h"

namespace latticed {

class DirtySet {
 public:
  // Nothing is dirty at first.
  explicit DirtySet(std::shared_ptr<const DeformPlan> plan);

  // Indices of control points that changed; they must be in range.
  void MarkControlPoints(std::span<const uint32_t> indices);
  void MarkAll();
  void Clear();

  bool empty() const { return chunk_count_ == 0; }
  // Dirty chunks, ascending.
  [[nodiscard]] std::vector<uint32_t> Chunks() const;
  // Boxes touched since Clear, and patches in them or borrowing from them: for EditResult.
  uint64_t boxes() const { return box_count_; }
  uint64_t patches() const { return patch_count_; }

 private:
  // The knot boxes first … last - 1 along an axis.
  struct Range {
    uint32_t first, last;
  };
  // The boxes that are influenced by control points with this index along the axis.
  Range BoxesOf(size_t axis, int index) const;
  void MarkBox(uint32_t box);
  // Marks the patches [first, last) of a box.
  void MarkOwnPatches(uint32_t first, uint32_t last);
  void MarkChunk(uint32_t chunk);

  std::shared_ptr<const DeformPlan> plan_;
  // By axis: how many boxes along it have a lower span than this one.
  std::array<std::vector<uint32_t>, 3> boxes_below_;
  std::vector<bool> chunk_dirty_;
  std::vector<uint8_t> box_dirty_;    // bytes: asked again and again
  std::vector<uint8_t> patch_dirty_;  // bytes: a run of them is counted and set at once
  uint64_t box_count_ = 0, patch_count_ = 0, chunk_count_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DIRTY_SET_H_
