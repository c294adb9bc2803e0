// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/surface_patterns.h"

#include <utility>

#include "core/ffd/tessellation_pattern.h"

namespace latticed {

SurfacePatterns::SurfacePatterns(const DeformPlan& plan, int segments)
    : patches_(plan.patches.size()) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  uniform_.denominator = segments;
  uniform_.points.reserve(pattern.points.size());
  for (const auto& [i0, i1, i2] : pattern.points) uniform_.points.push_back({i0, i1, i2});
  uniform_.triangles = pattern.triangles;
  uniform_.edge_points = pattern.edge_points;
}

SurfacePatterns::SurfacePatterns(std::vector<uint16_t> codes)
    : patches_(codes.size()), codes_(std::move(codes)) {}

uint64_t SurfacePatterns::PointCount() const {
  if (codes_.empty()) return patches_ * uniform_.points.size();
  uint64_t count = 0;
  for (size_t p = 0; p < patches_; ++p) count += Of(p).points.size();
  return count;
}

uint64_t SurfacePatterns::TriangleCount() const {
  if (codes_.empty()) return patches_ * uniform_.triangles.size();
  uint64_t count = 0;
  for (size_t p = 0; p < patches_; ++p) count += Of(p).triangles.size();
  return count;
}

size_t InnerPointCount(const AdaptivePattern& pattern) {
  size_t rim = 0;
  for (const auto& edge : pattern.edge_points) rim += edge.size() - 1;
  return pattern.points.size() - rim;
}

}  // namespace latticed
