// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_revisions.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/base/limits.h"
#include "core/patches/edge_order.h"

namespace latticed {
namespace {

void Raise(uint64_t& revision, uint64_t to) { revision = std::max(revision, to); }

// Of the control points with a non-zero basis function on a box.
uint64_t BoxRevision(const LatticeStructure& s, const std::array<int, 3>& span,
                     std::span<const uint64_t> points) {
  uint64_t newest = 0;
  for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
    for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
      const auto first = static_cast<size_t>(s.Index(span[0] - s.degree[0], j, k));
      const auto count = static_cast<size_t>(s.degree[0]) + 1;
      Raise(newest, std::ranges::max(points.subspan(first, count)));
    }
  }
  return newest;
}

// Of the control points of a turned lattice that make a patch dirty.
void RaiseByTurned(const DeformPlan& plan, const TurnedLattice& lattice,
                   const PointRevisions& points, std::vector<uint64_t>& patches) {
  const LatticeStructure& s = lattice.structure;
  std::vector<uint64_t> vertices(plan.vertices.size());
  for (size_t v = 0; v < vertices.size(); ++v) {
    const std::optional<PointRange> range = lattice.Reaching(v);
    if (!range.has_value()) continue;
    for (int k = range->first[2]; k <= range->last[2]; ++k) {
      for (int j = range->first[1]; j <= range->last[1]; ++j) {
        const auto first = static_cast<size_t>(s.Index(range->first[0], j, k));
        const auto count = static_cast<size_t>(range->last[0] - range->first[0]) + 1;
        Raise(vertices[v],
              std::ranges::max(points.revisions().subspan(lattice.first_point + first, count)));
      }
    }
  }
  for (size_t p = 0; p < patches.size(); ++p) {
    for (const uint32_t v : plan.patches[p].vertex) Raise(patches[p], vertices[v]);
  }
}

// As DirtySet marks patches: those of a box, and those that have a vertex or edge which it owns.
std::vector<uint64_t> PatchRevisions(const DeformPlan& plan, const PointRevisions& points) {
  std::vector<uint64_t> patches(plan.patches.size(), points.since());
  for (const TurnedLattice& lattice : plan.turned) RaiseByTurned(plan, lattice, points, patches);
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    const std::vector<uint32_t>& borrowers = plan.box_borrowers[b];
    const uint32_t first = plan.box_patches[b], last = plan.box_patches[b + 1];
    if (first == last && borrowers.empty()) continue;
    const uint64_t revision = BoxRevision(plan.structure, plan.boxes[b].span, points.revisions());
    for (uint32_t p = first; p < last; ++p) Raise(patches[p], revision);
    for (const uint32_t p : borrowers) Raise(patches[p], revision);
  }
  return patches;
}

// The newest of all patches with the edge.
std::vector<uint64_t> EdgeRevisions(const DeformPlan& plan, std::span<const uint64_t> patches) {
  std::vector<uint64_t> edges(plan.edges.size());
  for (size_t p = 0; p < patches.size(); ++p) {
    for (const uint32_t edge : plan.patches[p].edge) Raise(edges[edge], patches[p]);
  }
  return edges;
}

}  // namespace

std::vector<uint64_t> ChunkRevisions(const DeformPlan& plan, const PointRevisions& points,
                                     const ViewSpec& spec) {
  std::vector<uint64_t> chunks(plan.chunk_count(), points.since());
  if (std::ranges::all_of(points.revisions(), [&](uint64_t r) { return r <= points.since(); })) {
    return chunks;  // as of every new scene, without the memory of what follows
  }
  std::vector<uint64_t> patches = PatchRevisions(plan, points);
  if (!HasPositions(spec)) {
    const std::vector<uint64_t> edges = EdgeRevisions(plan, patches);
    const std::vector<uint32_t> first = FirstEdges(plan);
    for (size_t chunk = 0; chunk < chunks.size(); ++chunk) {
      for (uint32_t e = first[chunk]; e < first[chunk + 1]; ++e) Raise(chunks[chunk], edges[e]);
    }
    return chunks;
  }
  if (spec.tolerance > 0) {
    const std::vector<uint64_t> edges = EdgeRevisions(plan, patches);
    for (size_t p = 0; p < patches.size(); ++p) {
      for (const uint32_t edge : plan.patches[p].edge) Raise(patches[p], edges[edge]);
    }
  }
  for (size_t p = 0; p < patches.size(); ++p) {
    Raise(chunks[p / limits::kPatchesPerChunk], patches[p]);
  }
  return chunks;
}

}  // namespace latticed
