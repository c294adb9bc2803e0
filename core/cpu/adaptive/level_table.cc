// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/level_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/certificate.h"
#include "core/adaptive/edge_levels.h"
#include "core/base/limits.h"

namespace latticed {
namespace {

// Chunks of 32 patches, which take a few microseconds, for one task.
constexpr size_t kGrain = 4;
// The edges of so many chunks.
constexpr size_t kEdgeGrain = kGrain * limits::kPatchesPerChunk * 3 / 2;

// Infinite where a bound is not finite: a maximum may pass over one that is not a number.
double CertifiedError(double error, const CurvatureBounds<double>& bounds) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += bounds.edge[k] + bounds.mixed[k];
  return std::isfinite(sum) ? error : std::numeric_limits<double>::infinity();
}

float RoundedUp(double error) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return error > 0 ? std::nextafter(static_cast<float>(error), kInfinity) : 0;
}

CurvatureBounds<double> ToDouble(const CurvatureBounds<float>& bounds) {
  CurvatureBounds<double> wide;
  for (int e = 0; e < 3; ++e) {
    wide.edge[e] = bounds.edge[e];
    wide.mixed[e] = bounds.mixed[e];
  }
  return wide;
}

}  // namespace

LevelTable::LevelTable(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)),
      first_use_(plan_->edges.size() + 1),
      uses_(3 * plan_->patches.size()),
      bounds_(plan_->patches.size()),
      levels_(plan_->edges.size()),
      codes_(std::make_shared<std::vector<uint16_t>>(plan_->patches.size())),
      chunks_(plan_->chunk_count()),
      marks_(plan_->chunk_count()) {
  for (const Patch& patch : plan_->patches) {
    for (const uint32_t edge : patch.edge) ++first_use_[edge + 1];
  }
  for (size_t e = 0; e < plan_->edges.size(); ++e) first_use_[e + 1] += first_use_[e];
  std::vector<uint32_t> next(first_use_.begin(), first_use_.end() - 1);
  for (uint32_t p = 0; p < plan_->patches.size(); ++p) {
    for (uint32_t slot = 0; slot < 3; ++slot) {
      uses_[next[plan_->patches[p].edge[slot]]++] = {p, slot};
    }
  }
}

std::vector<uint32_t> LevelTable::Update(std::span<const uint32_t> chunks, double tolerance,
                                         CpuArena& arena) {
  if (codes_.use_count() > 1) codes_ = std::make_shared<std::vector<uint16_t>>(*codes_);
  for (const uint32_t chunk : chunks) marks_[chunk] = Mark::kNamed;
  if (chunks.size() == chunks_.size()) {
    arena.ForEach(
        levels_.size(), [&](size_t e) { UpdateEdge(static_cast<uint32_t>(e), tolerance); },
        kEdgeGrain);
  } else {
    arena.ForEach(
        chunks.size(), [&](size_t i) { UpdateEdges(chunks[i], tolerance); }, kGrain);
  }
  for (size_t i = 0; i < shared_edges_.size(); ++i) {
    SetLevel(shared_edges_[i], EdgeLevel<double>(shared_bounds_[i], tolerance));
  }
  std::vector<uint32_t> marked;
  for (uint32_t chunk = 0; chunk < marks_.size(); ++chunk) {
    if (marks_[chunk] != Mark::kNone) marked.push_back(chunk);
  }
  arena.ForEach(
      marked.size(), [&](size_t i) { UpdatePatches(marked[i], tolerance); }, kGrain);
  std::vector<uint32_t> changed;
  for (const uint32_t chunk : marked) {
    if (marks_[chunk].exchange(Mark::kNone) == Mark::kChanged) changed.push_back(chunk);
  }
  point_count_ = 0;
  for (const Chunk& chunk : chunks_) point_count_ += chunk.points;
  return changed;
}

void LevelTable::Share(std::span<const uint32_t> edges) {
  shared_edges_.assign(edges.begin(), edges.end());
  shared_bounds_.assign(edges.size(), 0);
  is_shared_.assign(plan_->edges.size(), false);
  for (const uint32_t edge : edges) is_shared_[edge] = true;
}

std::span<const float> LevelTable::SharedBounds() {
  std::ranges::transform(shared_edges_, shared_bounds_.begin(),
                         [this](uint32_t edge) { return LargestBound(edge); });
  return shared_bounds_;
}

void LevelTable::SetSharedBounds(std::span<const float> bounds) {
  std::ranges::copy(bounds, shared_bounds_.begin());
}

float LevelTable::LargestBound(uint32_t edge) const {
  float largest = 0;
  for (const auto [patch, slot] : UsesOf(edge)) {
    largest = LargerBound(largest, bounds_[patch].edge[slot]);
  }
  return largest;
}

void LevelTable::UpdateEdges(uint32_t chunk, double tolerance) {
  const auto [first, last] = plan_->ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) {
    for (uint32_t slot = 0; slot < 3; ++slot) {
      const uint32_t edge = plan_->patches[p].edge[slot];
      // Only one thread updates an edge: that of its first patch in a named chunk.
      const auto named = std::ranges::find_if(UsesOf(edge), [&](const EdgeUse& use) {
        return marks_[ChunkOf(use.patch)].load(std::memory_order_relaxed) == Mark::kNamed;
      });
      if (named->patch == p && named->slot == slot) UpdateEdge(edge, tolerance);
    }
  }
}

void LevelTable::UpdateEdge(uint32_t edge, double tolerance) {
  if (!is_shared_.empty() && is_shared_[edge]) return;
  SetLevel(edge, EdgeLevel<double>(LargestBound(edge), tolerance));
}

void LevelTable::SetLevel(uint32_t edge, uint8_t level) {
  if (std::exchange(levels_[edge], level) == level) return;
  for (const EdgeUse& use : UsesOf(edge)) {
    Mark none = Mark::kNone;
    marks_[ChunkOf(use.patch)].compare_exchange_strong(none, Mark::kBeside,
                                                       std::memory_order_relaxed);
  }
}

void LevelTable::UpdatePatches(uint32_t chunk, double tolerance) {
  const auto [first, last] = plan_->ChunkPatches(chunk);
  Chunk now;
  double largest_error = 0;
  for (size_t p = first; p < last; ++p) {
    const auto& edges = plan_->patches[p].edge;
    const CurvatureBounds<double> bounds = ToDouble(bounds_[p]);
    const PatternChoice choice =
        ChoosePattern({levels_[edges[0]], levels_[edges[1]], levels_[edges[2]]}, bounds, tolerance);
    now.points += static_cast<uint32_t>(choice.pattern.points.size());
    largest_error = std::max(largest_error, CertifiedError(choice.error, bounds));
    const uint16_t code = choice.pattern.key.Code();
    if (std::exchange((*codes_)[p], code) != code) marks_[chunk] = Mark::kChanged;
  }
  now.largest_error = RoundedUp(largest_error);
  chunks_[chunk] = now;
}

double LevelTable::LargestError() const {
  float largest = 0;
  for (const Chunk& chunk : chunks_) largest = std::max(largest, chunk.largest_error);
  return largest;
}

size_t LevelTable::MemoryBytes() const {
  return BytesFor(*plan_) + shared_edges_.size() * (sizeof(uint32_t) + sizeof(float)) +
         is_shared_.size() / 8;
}

size_t LevelTable::BytesFor(const DeformPlan& plan) {
  return plan.edges.size() * (sizeof(uint32_t) + sizeof(uint8_t)) +
         plan.patches.size() *
             (3 * sizeof(EdgeUse) + sizeof(CurvatureBounds<float>) + sizeof(uint16_t)) +
         plan.chunk_count() * (sizeof(Chunk) + sizeof(Mark));
}

}  // namespace latticed
