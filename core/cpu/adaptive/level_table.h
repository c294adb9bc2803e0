// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The patterns of all patches of a view with a tolerance, kept up to date with the bounds of their second derivatives.
//
//   level of an edge     core/adaptive/edge_levels.h, from the largest bound along it in all of its patches
//   pattern of a patch   ChoosePattern of its three levels and its own bounds
//
// Both depend on the present bounds and the tolerance alone, and neither on the order of edits nor on the number of threads.
// A patch whose bounds did not change gets another pattern where a neighbour changed the level of an edge that they share.
//
// Units    world
// Threads  SetBounds of different patches may run at once; otherwise one thread at a time. Update uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/adaptive/patch_curvature.h"
#include "core/adaptive/pattern_key.h"
#include "core/base/limits.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class LevelTable {
 public:
  // All bounds are 0 at first, and so are all levels.
  explicit LevelTable(std::shared_ptr<const DeformPlan> plan);

  void SetBounds(size_t patch, const CurvatureBounds<float>& bounds) { bounds_[patch] = bounds; }

  // Brings levels and patterns up to date after SetBounds of the patches of `chunks`, which ascend, or of all patches
  // where `tolerance` is another one. tolerance: the part for curvature, see CurvatureTolerance. Returns the chunks with
  // a patch whose pattern changed, ascending.
  [[nodiscard]] std::vector<uint32_t> Update(std::span<const uint32_t> chunks, double tolerance,
                                             CpuArena& arena);

  // For a slice of a plan: edges that other slices have too. Their levels are those of SetSharedBounds, not of the bounds
  // here; Update looks at all of them.
  void Share(std::span<const uint32_t> edges);
  // The largest bound along each of these edges in the patches here.
  std::span<const float> SharedBounds();
  // The same in the patches of all slices.
  void SetSharedBounds(std::span<const float> bounds);

  // PatternKey::Code of each patch. The vector is left as it is while others have it.
  std::shared_ptr<const std::vector<uint16_t>> codes() const { return codes_; }
  uint64_t point_count() const { return point_count_; }
  // The largest PatternError of all patches.
  double LargestError() const;
  size_t MemoryBytes() const;
  static size_t BytesFor(const DeformPlan& plan);

 private:
  struct EdgeUse {
    uint32_t patch;
    uint32_t slot;
  };

  struct Chunk {
    uint32_t points = 0;
    float largest_error = 0;  // rounded up
  };
  // Why an Update looks at the patches of a chunk, and what it found.
  enum class Mark : uint8_t {
    kNone,
    kNamed,
    kBeside,   // the level of an edge changed, which a patch shares with one of a named chunk
    kChanged,  // a patch has another pattern
  };

  static size_t ChunkOf(uint32_t patch) { return patch / limits::kPatchesPerChunk; }
  std::span<const EdgeUse> UsesOf(uint32_t edge) const {
    return {uses_.data() + first_use_[edge], uses_.data() + first_use_[edge + 1]};
  }
  float LargestBound(uint32_t edge) const;
  // Of the edges whose first patch in a named chunk is in this one.
  void UpdateEdges(uint32_t chunk, double tolerance);
  void UpdateEdge(uint32_t edge, double tolerance);
  void SetLevel(uint32_t edge, uint8_t level);
  void UpdatePatches(uint32_t chunk, double tolerance);

  const std::shared_ptr<const DeformPlan> plan_;
  // The patches of edge e, ascending, are uses_[first_use_[e]] … uses_[first_use_[e + 1] - 1].
  std::vector<uint32_t> first_use_;
  std::vector<EdgeUse> uses_;
  std::vector<CurvatureBounds<float>> bounds_;    // by patch
  std::vector<uint8_t> levels_;                   // by edge
  std::shared_ptr<std::vector<uint16_t>> codes_;  // by patch
  std::vector<Chunk> chunks_;
  // Of edges that other slices have too; empty where there is no other.
  std::vector<uint32_t> shared_edges_;
  std::vector<bool> is_shared_;  // by edge
  std::vector<float> shared_bounds_;
  uint64_t point_count_ = 0;
  std::vector<std::atomic<Mark>> marks_;  // by chunk; all kNone between two calls of Update
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_LEVEL_TABLE_H_
