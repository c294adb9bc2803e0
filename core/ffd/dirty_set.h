// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks that edits have touched since the last update.
//
// Control point (i,j,k) influences the boxes whose spans are in i … i+nu, j … j+nv, k … k+nw. Its move makes the chunks
// of all patches in those boxes dirty. It does so also with the chunks of patches elsewhere that have a vertex or edge
// owned by one of those boxes: re-evaluating the owner can change the last bits of points that the edit cannot move.
//
// Threads  plain data; one thread at a time
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

  // Marks what the control points with these indices influence. The indices must be in range.
  void MarkControlPoints(std::span<const uint32_t> indices);
  void MarkAll();
  void Clear();

  bool empty() const { return chunk_count_ == 0; }
  // Dirty chunks, ascending.
  [[nodiscard]] std::vector<uint32_t> Chunks() const;
  // For EditResult: boxes touched since Clear, and patches in them or with a vertex or edge that they own.
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
  // By axis and span: the number of boxes along the axis with a lower span.
  std::array<std::vector<uint32_t>, 3> boxes_below_;
  std::vector<bool> chunk_dirty_;
  std::vector<uint8_t> box_dirty_;    // bytes, because it is read often
  std::vector<uint8_t> patch_dirty_;  // bytes, so that a run is counted and set at once
  uint64_t box_count_ = 0, patch_count_ = 0, chunk_count_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DIRTY_SET_H_
