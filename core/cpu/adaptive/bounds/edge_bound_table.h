// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One byte per edge of a plan: the largest bound along it in all of its patches (core/patches/edge_bound.h), kept up to
// date with the bounds of patches. The bytes depend on the present bounds alone, and neither on the order of edits nor on
// the number of threads.
//
// Units    world
// Threads  SetBounds of different patches may run at once; otherwise one thread at a time. Update uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_TABLE_H_
#define LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_TABLE_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/adaptive/patch_curvature.h"
#include "core/base/limits.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

class EdgeBoundTable {
 public:
  // All bounds are 0 at first, and so are all bytes.
  explicit EdgeBoundTable(std::shared_ptr<const DeformPlan> plan);

  void SetBounds(size_t patch, const CurvatureBounds<float>& bounds) {
    bounds_[patch] = {bounds.edge[0], bounds.edge[1], bounds.edge[2]};
  }

  // Brings the bytes up to date after SetBounds of the patches of `chunks`, which ascend. Returns the chunks with a byte
  // that changed, ascending.
  [[nodiscard]] std::vector<uint32_t> Update(std::span<const uint32_t> chunks, CpuArena& arena);

  // The bytes of the edges that a chunk uses first.
  std::span<const uint8_t> operator[](uint32_t chunk) const {
    return std::span(bytes_).subspan(first_edge_[chunk], Size(chunk));
  }
  size_t Size(uint32_t chunk) const { return first_edge_[chunk + 1] - first_edge_[chunk]; }
  size_t MemoryBytes() const { return BytesFor(*plan_); }
  static size_t BytesFor(const DeformPlan& plan);

 private:
  std::span<const uint32_t> UsesOf(uint32_t edge) const {
    return std::span(uses_).subspan(first_use_[edge], first_use_[edge + 1] - first_use_[edge]);
  }
  static size_t ChunkOf(uint32_t use) { return use / (3 * limits::kPatchesPerChunk); }
  void UpdateEdges(uint32_t chunk);
  void UpdateEdge(uint32_t edge);

  const std::shared_ptr<const DeformPlan> plan_;
  const double unit_;
  const std::vector<uint32_t> first_edge_;  // by chunk: FirstEdges
  // Edge e is edge uses_[i] % 3 of patch uses_[i] / 3 for the i in first_use_[e] … first_use_[e + 1] - 1. They ascend.
  std::vector<uint32_t> first_use_, uses_;
  std::vector<std::array<float, 3>> bounds_;  // by patch
  std::vector<uint8_t> bytes_;                // by edge
  // By chunk, all false between two calls of Update.
  std::vector<uint8_t> is_named_;
  std::vector<std::atomic<bool>> is_changed_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_BOUNDS_EDGE_BOUND_TABLE_H_
