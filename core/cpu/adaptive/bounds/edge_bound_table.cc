// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/bounds/edge_bound_table.h"

#include <utility>

#include "core/patches/edge_bound.h"
#include "core/patches/edge_order.h"

namespace latticed {
namespace {

// Chunks of 32 patches, which take a few microseconds, for one task.
constexpr size_t kChunksOfTask = 4;

}  // namespace

// A plan has at most limits::kMaxPatches patches, so three times their number fits 32 bits.
EdgeBoundTable::EdgeBoundTable(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)),
      unit_(CurvatureUnit(plan_->mesh_bounds)),
      first_edge_(FirstEdges(*plan_)),
      first_use_(plan_->edges.size() + 1),
      uses_(3 * plan_->patches.size()),
      bounds_(plan_->patches.size()),
      bytes_(plan_->edges.size()),
      is_named_(plan_->chunk_count()),
      is_changed_(plan_->chunk_count()) {
  for (const Patch& patch : plan_->patches) {
    for (const uint32_t edge : patch.edge) ++first_use_[edge + 1];
  }
  for (size_t e = 0; e < plan_->edges.size(); ++e) first_use_[e + 1] += first_use_[e];
  std::vector<uint32_t> next(first_use_.begin(), first_use_.end() - 1);
  uint32_t use = 0;
  for (const Patch& patch : plan_->patches) {
    for (const uint32_t edge : patch.edge) uses_[next[edge]++] = use++;
  }
}

std::vector<uint32_t> EdgeBoundTable::Update(std::span<const uint32_t> chunks, CpuArena& arena) {
  for (const uint32_t chunk : chunks) is_named_[chunk] = 1;
  arena.ForEach(
      chunks.size(), [&](size_t i) { UpdateEdges(chunks[i]); }, kChunksOfTask);
  for (const uint32_t chunk : chunks) is_named_[chunk] = 0;
  std::vector<uint32_t> changed;
  for (uint32_t chunk = 0; chunk < is_changed_.size(); ++chunk) {
    if (is_changed_[chunk].exchange(false, std::memory_order_relaxed)) changed.push_back(chunk);
  }
  return changed;
}

void EdgeBoundTable::UpdateEdges(uint32_t chunk) {
  const auto [first, last] = plan_->ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) {
    for (size_t e = 0; e < 3; ++e) {
      const uint32_t edge = plan_->patches[p].edge[e];
      // Only one thread updates an edge: that of its first patch in a named chunk.
      for (const uint32_t use : UsesOf(edge)) {
        if (is_named_[ChunkOf(use)] == 0) continue;
        if (use == 3 * p + e) UpdateEdge(edge);
        break;
      }
    }
  }
}

void EdgeBoundTable::UpdateEdge(uint32_t edge) {
  float largest = 0;
  for (const uint32_t use : UsesOf(edge)) {
    largest = LargerBound(largest, bounds_[use / 3][use % 3]);
  }
  const uint8_t byte = EdgeBoundByte(largest, unit_);
  if (std::exchange(bytes_[edge], byte) == byte) return;
  is_changed_[ChunkOf(UsesOf(edge).front())].store(true, std::memory_order_relaxed);
}

size_t EdgeBoundTable::BytesFor(const DeformPlan& plan) {
  return plan.edges.size() * (sizeof(uint32_t) + sizeof(uint8_t)) +
         plan.patches.size() * 3 * (sizeof(uint32_t) + sizeof(float)) +
         plan.chunk_count() * (sizeof(uint32_t) + 2);
}

}  // namespace latticed
