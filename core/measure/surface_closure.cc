// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_closure.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace latticed {
namespace {

// For each vertex, the number of its position and weight.
std::vector<uint32_t> WeldedVertices(const std::vector<Vec3d>& positions,
                                     const VertexWeights& weights) {
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto weight = [&](uint32_t v) { return weights == nullptr ? 1 : (*weights)[v]; };
  std::ranges::sort(order, [&](uint32_t a, uint32_t b) {
    return positions[a] == positions[b] ? weight(a) < weight(b) : positions[a] < positions[b];
  });
  std::vector<uint32_t> welded(positions.size());
  for (size_t n = 0; n < order.size(); ++n) {
    const bool same = n > 0 && positions[order[n]] == positions[order[n - 1]] &&
                      weight(order[n]) == weight(order[n - 1]);
    welded[order[n]] = same ? welded[order[n - 1]] : order[n];
  }
  return welded;
}

}  // namespace

uint64_t CountBorderEdges(const PolygonMesh& mesh, const VertexWeights& weights) {
  const std::vector<uint32_t> welded = WeldedVertices(mesh.positions, weights);
  struct Side {
    uint64_t edge;  // its lower vertex above its higher one
    int direction;
  };
  std::vector<Side> sides;
  sides.reserve(mesh.corner_count());
  for (size_t face = 0; face < mesh.face_count(); ++face) {
    const uint32_t begin = mesh.face_offsets[face], end = mesh.face_offsets[face + 1];
    for (uint32_t c = begin; c < end; ++c) {
      const uint64_t a = welded[mesh.corner_vertices[c]];
      const uint64_t b = welded[mesh.corner_vertices[c + 1 == end ? begin : c + 1]];
      if (a != b) sides.push_back({std::min(a, b) << 32 | std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::ranges::sort(sides, {}, &Side::edge);
  uint64_t borders = 0;
  for (size_t n = 0; n < sides.size();) {
    const uint64_t edge = sides[n].edge;
    int sum = 0;
    for (; n < sides.size() && sides[n].edge == edge; ++n) sum += sides[n].direction;
    borders += sum != 0 ? 1 : 0;
  }
  return borders;
}

uint64_t CountTornEdges(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  if (plan.seams.empty()) return 0;
  const std::vector<bool> attached = AttachedSeams(plan, control_points);
  return static_cast<uint64_t>(std::ranges::count_if(plan.edges, [&](const PlanEdge& edge) {
    return edge.seam != kNoIndex && !attached[edge.seam];
  }));
}

absl::Status CheckClosed(uint64_t border_edges, uint64_t torn_edges) {
  if (border_edges == 0 && torn_edges == 0) return absl::OkStatus();
  return error::OpenSurface(border_edges, torn_edges);
}

}  // namespace latticed
