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

// Rounded up. Infinite where a bound is not finite: a maximum may pass over one that is not a number.
float ErrorOf(const AdaptivePattern& pattern, const CurvatureBounds<double>& bounds) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += bounds.edge[k] + bounds.mixed[k];
  if (!std::isfinite(sum)) return kInfinity;
  const auto error = static_cast<float>(PatternError(pattern, bounds));
  return error > 0 ? std::nextafter(error, kInfinity) : 0;
}

}  // namespace

LevelTable::LevelTable(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)),
      first_use_(plan_->edges.size() + 1),
      uses_(3 * plan_->patches.size()),
      bounds_(plan_->patches.size()),
      levels_(plan_->edges.size()),
      codes_(plan_->patches.size()),
      errors_(plan_->patches.size()),
      point_count_(3 * plan_->patches.size()),
      edge_turns_(plan_->edges.size()),
      patch_turns_(plan_->patches.size()) {
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

std::vector<uint32_t> LevelTable::Update(std::span<const uint32_t> chunks, double tolerance) {
  ++turn_;
  touched_.clear();
  for (const uint32_t chunk : chunks) {
    const auto [first, last] = plan_->ChunkPatches(chunk);
    for (size_t p = first; p < last; ++p) Touch(static_cast<uint32_t>(p));
  }
  for (const uint32_t chunk : chunks) {
    const auto [first, last] = plan_->ChunkPatches(chunk);
    for (size_t p = first; p < last; ++p) {
      for (const uint32_t edge : plan_->patches[p].edge) UpdateEdge(edge, tolerance);
    }
  }
  std::vector<uint32_t> changed;
  for (const uint32_t patch : touched_) {
    if (!UpdatePatch(patch, tolerance)) continue;
    const auto chunk = static_cast<uint32_t>(patch / limits::kPatchesPerChunk);
    if (changed.empty() || changed.back() != chunk) changed.push_back(chunk);
  }
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  return changed;
}

void LevelTable::Touch(uint32_t patch) {
  if (std::exchange(patch_turns_[patch], turn_) != turn_) touched_.push_back(patch);
}

void LevelTable::UpdateEdge(uint32_t edge, double tolerance) {
  if (std::exchange(edge_turns_[edge], turn_) == turn_) return;
  const auto uses =
      std::span(uses_).subspan(first_use_[edge], first_use_[edge + 1] - first_use_[edge]);
  float largest = 0;
  for (const auto [patch, slot] : uses) {
    const float bound = bounds_[patch].edge[slot];
    if (!(bound <= largest)) largest = bound;  // one that is not a number counts too
  }
  // An infinite tolerance asks for nothing, not even where a bound is not a number.
  const uint8_t level = std::isfinite(tolerance) ? EdgeLevel<double>(largest, tolerance) : 0;
  if (std::exchange(levels_[edge], level) == level) return;
  for (const EdgeUse& use : uses) Touch(use.patch);
}

bool LevelTable::UpdatePatch(uint32_t patch, double tolerance) {
  const auto& edges = plan_->patches[patch].edge;
  const std::array<uint8_t, 3> levels{levels_[edges[0]], levels_[edges[1]], levels_[edges[2]]};
  CurvatureBounds<double> bounds;
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = bounds_[patch].edge[e];
    bounds.mixed[e] = bounds_[patch].mixed[e];
  }
  const PatternKey key = ChoosePattern(levels, bounds, tolerance);
  const AdaptivePattern& pattern = AdaptivePattern::Get(key);
  errors_[patch] = ErrorOf(pattern, bounds);
  const uint16_t code = key.Code(), before = std::exchange(codes_[patch], code);
  if (code == before) return false;
  point_count_ += pattern.points.size();
  point_count_ -= AdaptivePattern::Get(*PatternKey::FromCode(before)).points.size();
  return true;
}

double LevelTable::LargestError() const {
  return errors_.empty() ? 0 : *std::ranges::max_element(errors_);
}

size_t LevelTable::BytesFor(const DeformPlan& plan) {
  return plan.edges.size() * (2 * sizeof(uint32_t) + sizeof(uint8_t)) +
         plan.patches.size() * (3 * sizeof(EdgeUse) + sizeof(CurvatureBounds<float>) +
                                sizeof(uint16_t) + sizeof(float) + 2 * sizeof(uint32_t));
}

}  // namespace latticed
