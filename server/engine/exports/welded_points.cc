// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/welded_points.h"

#include <algorithm>
#include <numeric>

#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

// Turns counts into the numbers at which they begin, from `first` on. Returns the number after the last.
uint32_t Accumulate(std::vector<uint32_t>& counts, uint32_t first) {
  for (uint32_t& count : counts) {
    const uint32_t begin = first;
    first += count;
    count = begin;
  }
  return first;
}

}  // namespace

WeldedPoints::WeldedPoints(const DeformPlan& plan, std::span<const Vec3d> control_points,
                           const SurfacePatterns& patterns, Welding welding)
    : plan_(plan), patterns_(patterns), welding_(welding), first_of_patch_(plan.patches.size()) {
  if (welding == Welding::kShared) {
    WeldFeatures(control_points);
    return;
  }
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    first_of_patch_[p] = static_cast<uint32_t>(patterns.Of(p).points.size());
  }
  count_ = Accumulate(first_of_patch_, 0);
}

void WeldedPoints::WeldFeatures(std::span<const Vec3d> control_points) {
  const DeformPlan& plan = plan_;
  first_of_edge_.resize(plan.edges.size());
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const AdaptivePattern& pattern = patterns_.Of(p);
    first_of_patch_[p] = static_cast<uint32_t>(InnerPointCount(pattern));
    for (size_t e = 0; e < 3; ++e) {
      first_of_edge_[plan.patches[p].edge[e]] =
          static_cast<uint32_t>(pattern.edge_points[e].size() - 2);
    }
  }
  const std::vector<bool> attached =
      plan.seams.empty() ? std::vector<bool>() : AttachedSeams(plan, control_points);
  const auto is_torn = [&](uint32_t seam) { return seam != kNoIndex && !attached[seam]; };
  for (uint32_t e = 0; e < plan.edges.size(); ++e) {
    if (is_torn(plan.edges[e].seam)) torn_edges_[e] = first_of_edge_[e];
  }
  count_ = Accumulate(first_of_edge_, static_cast<uint32_t>(plan.vertices.size()));
  count_ = Accumulate(first_of_patch_, count_);
  for (uint32_t v = 0; v < plan.vertices.size(); ++v) {
    if (is_torn(plan.vertices[v].seam)) torn_vertices_[v] = count_++;
  }
  for (uint32_t e = 0; e < plan.edges.size(); ++e) {
    const auto torn = torn_edges_.find(e);
    if (torn == torn_edges_.end()) continue;
    const uint32_t inner = torn->second;
    torn->second = count_;
    count_ += inner;
  }
}

uint64_t WeldedPoints::Most(const DeformPlan& plan, int segments) {
  const auto in_edge = static_cast<uint64_t>(segments - 1);
  const uint64_t in_patch = in_edge * static_cast<uint64_t>(std::max(segments - 2, 0)) / 2;
  return plan.vertices.size() + plan.edges.size() * in_edge + plan.patches.size() * in_patch +
         plan.seam_patches * 3 * (1 + in_edge);
}

uint32_t WeldedPoints::VertexNumber(const Patch& patch, uint32_t vertex) const {
  if (patch.box != plan_.outside_box()) return vertex;
  const auto torn = torn_vertices_.find(vertex);
  return torn == torn_vertices_.end() ? vertex : torn->second;
}

uint32_t WeldedPoints::EdgeNumber(const Patch& patch, uint32_t edge) const {
  if (patch.box != plan_.outside_box()) return first_of_edge_[edge];
  const auto torn = torn_edges_.find(edge);
  return torn == torn_edges_.end() ? first_of_edge_[edge] : torn->second;
}

std::vector<uint32_t> WeldedPoints::OfPatch(size_t index) const {
  const Patch& patch = plan_.patches[index];
  const AdaptivePattern& pattern = patterns_.Of(index);
  std::vector<uint32_t> numbers(pattern.points.size());
  if (welding_ == Welding::kNone) {
    std::iota(numbers.begin(), numbers.end(), first_of_patch_[index]);
    return numbers;
  }
  for (size_t e = 0; e < 3; ++e) {
    const std::vector<uint16_t>& points = pattern.edge_points[e];
    const size_t segments = points.size() - 1;
    numbers[points.front()] = VertexNumber(patch, patch.vertex[e]);
    const uint32_t first = EdgeNumber(patch, patch.edge[e]);
    for (size_t k = 1; k < segments; ++k) {
      const size_t along = patch.edge_reversed[e] ? segments - k : k;
      numbers[points[k]] = first + static_cast<uint32_t>(along - 1);
    }
  }
  uint32_t inner = first_of_patch_[index];
  for (size_t i = 0; i < pattern.points.size(); ++i) {
    if (std::ranges::count(pattern.points[i], 0) == 0) numbers[i] = inner++;
  }
  return numbers;
}

}  // namespace latticed
