// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The patterns of all patches of a view with a tolerance, kept up to date with the bounds of their second derivatives.
//
//   level of an edge     core/adaptive/edge_levels.h, from the largest bound along it in all of its patches
//   pattern of a patch   ChoosePattern of its three levels and its own bounds
//
// Both depend on the present bounds and the tolerance alone, and not on the order of edits. A patch whose bounds did not
// change gets another pattern where a neighbour changed the level of an edge that they share.
//
// Units    world
// Threads  SetBounds of different patches may run at once; otherwise one thread at a time
#ifndef LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/adaptive/patch_curvature.h"
#include "core/adaptive/pattern_key.h"
#include "core/ffd/deform_plan.h"

namespace latticed {

class LevelTable {
 public:
  // All bounds are 0 at first, and so are all levels.
  explicit LevelTable(std::shared_ptr<const DeformPlan> plan);

  void SetBounds(size_t patch, const CurvatureBounds<float>& bounds) { bounds_[patch] = bounds; }

  // Brings levels and patterns up to date after SetBounds of the patches of `chunks`, which ascend, or of all patches
  // where `tolerance` is another one. tolerance: the part for curvature, see CurvatureTolerance. Returns the chunks with
  // a patch whose pattern changed, ascending.
  [[nodiscard]] std::vector<uint32_t> Update(std::span<const uint32_t> chunks, double tolerance);

  // PatternKey::Code of each patch.
  std::span<const uint16_t> codes() const { return codes_; }
  uint64_t point_count() const { return point_count_; }
  // The largest PatternError of all patches.
  double LargestError() const;
  size_t MemoryBytes() const { return BytesFor(*plan_); }
  static size_t BytesFor(const DeformPlan& plan);

 private:
  struct EdgeUse {
    uint32_t patch;
    uint32_t slot;
  };

  void UpdateEdge(uint32_t edge, double tolerance);
  // Returns whether the pattern changed.
  bool UpdatePatch(uint32_t patch, double tolerance);
  void Touch(uint32_t patch);

  const std::shared_ptr<const DeformPlan> plan_;
  // The patches of edge e are uses_[first_use_[e]] … uses_[first_use_[e + 1] - 1].
  std::vector<uint32_t> first_use_;
  std::vector<EdgeUse> uses_;
  std::vector<CurvatureBounds<float>> bounds_;  // by patch
  std::vector<uint8_t> levels_;                 // by edge
  std::vector<uint16_t> codes_;                 // by patch
  std::vector<float> errors_;                   // by patch, rounded up
  uint64_t point_count_ = 0;
  // Of the Update that runs.
  uint32_t turn_ = 0;
  std::vector<uint32_t> edge_turns_, patch_turns_;  // the last turn in which each was looked at
  std::vector<uint32_t> touched_;                   // patches to update
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_
