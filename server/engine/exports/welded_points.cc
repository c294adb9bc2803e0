// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/welded_points.h"

#include <algorithm>

namespace latticed {
namespace {

std::vector<uint16_t> InnerPoints(const TessellationPattern& pattern) {
  std::vector<uint16_t> inner;
  for (size_t i = 0; i < pattern.points.size(); ++i) {
    if (std::ranges::count(pattern.points[i], 0) == 0) inner.push_back(static_cast<uint16_t>(i));
  }
  return inner;
}

uint64_t InnerCount(int segments) {
  return static_cast<uint64_t>((segments - 1) * (segments - 2) / 2);
}

}  // namespace

WeldedPoints::WeldedPoints(const DeformPlan& plan, std::span<const Vec3d> control_points,
                           int segments)
    : plan_(plan),
      pattern_(TessellationPattern::Get(segments)),
      inner_points_(InnerPoints(pattern_)) {
  const auto in_edge = static_cast<uint32_t>(segments - 1);
  first_edge_ = static_cast<uint32_t>(plan.vertices.size());
  first_patch_ = first_edge_ + static_cast<uint32_t>(plan.edges.size()) * in_edge;
  count_ = first_patch_ + static_cast<uint32_t>(plan.patches.size() * inner_points_.size());
  if (plan.seams.empty()) return;
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  const auto is_torn = [&](uint32_t seam) { return seam != kNoIndex && !attached[seam]; };
  for (uint32_t v = 0; v < plan.vertices.size(); ++v) {
    if (is_torn(plan.vertices[v].seam)) torn_vertices_[v] = count_++;
  }
  for (uint32_t e = 0; e < plan.edges.size(); ++e) {
    if (!is_torn(plan.edges[e].seam)) continue;
    torn_edges_[e] = count_;
    count_ += in_edge;
  }
}

uint64_t WeldedPoints::Most(const DeformPlan& plan, int segments) {
  const auto in_edge = static_cast<uint64_t>(segments - 1);
  return plan.vertices.size() + plan.edges.size() * in_edge +
         plan.patches.size() * InnerCount(segments) + plan.seam_patches * 3 * (1 + in_edge);
}

uint32_t WeldedPoints::VertexNumber(const Patch& patch, uint32_t vertex) const {
  if (patch.box != plan_.outside_box()) return vertex;
  const auto torn = torn_vertices_.find(vertex);
  return torn == torn_vertices_.end() ? vertex : torn->second;
}

uint32_t WeldedPoints::EdgeNumber(const Patch& patch, uint32_t edge) const {
  const auto in_edge = static_cast<uint32_t>(pattern_.segments - 1);
  const uint32_t number = first_edge_ + edge * in_edge;
  if (patch.box != plan_.outside_box()) return number;
  const auto torn = torn_edges_.find(edge);
  return torn == torn_edges_.end() ? number : torn->second;
}

std::vector<uint32_t> WeldedPoints::OfPatch(size_t index) const {
  const Patch& patch = plan_.patches[index];
  const auto segments = static_cast<size_t>(pattern_.segments);
  std::vector<uint32_t> numbers(pattern_.points.size());
  for (size_t e = 0; e < 3; ++e) {
    const std::vector<uint16_t>& points = pattern_.edge_points[e];
    numbers[points.front()] = VertexNumber(patch, patch.vertex[e]);
    const uint32_t first = EdgeNumber(patch, patch.edge[e]);
    for (size_t k = 1; k < segments; ++k) {
      const size_t along = patch.edge_reversed[e] ? segments - k : k;
      numbers[points[k]] = first + static_cast<uint32_t>(along - 1);
    }
  }
  auto inner = first_patch_ + static_cast<uint32_t>(index * inner_points_.size());
  for (const uint16_t point : inner_points_) numbers[point] = inner++;
  return numbers;
}

}  // namespace latticed
