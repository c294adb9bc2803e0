// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/scene_state.h"

#include <algorithm>
#include <array>
#include <set>

namespace latticed {

std::vector<bool> InfluentialPoints(const DeformPlan& plan) {
  std::vector<bool> influential(plan.control_point_count());
  const auto add = [&](const LatticeStructure& s, size_t first, const std::array<int, 3>& span) {
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          influential[first + static_cast<size_t>(s.Index(i, j, k))] = true;
        }
      }
    }
  };
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    if (plan.box_patches[b] == plan.box_patches[b + 1]) continue;
    add(plan.structure, 0, plan.boxes[b].span);
  }
  for (const TurnedLattice& lattice : plan.turned) {
    for (const KnotSpans& spans : std::set(lattice.spans.begin(), lattice.spans.end())) {
      if (spans != kNoSpans) add(lattice.structure, lattice.first_point, spans);
    }
  }
  return influential;
}

uint64_t PatchesThatMayTear(const DeformPlan& plan, const SceneLattices& lattices) {
  if (lattices[0].map->is_identity()) return plan.seam_patches;
  const auto may_tear = [&](const Seam& seam) {
    bool moves = false;
    if (seam.rests) return moves;
    for (int k = seam.first[2]; k <= seam.last[2]; ++k) {
      for (int j = seam.first[1]; j <= seam.last[1]; ++j) {
        for (int i = seam.first[0]; i <= seam.last[0]; ++i) {
          const auto index = static_cast<size_t>(plan.structure.Index(i, j, k));
          for (const SceneLattice& lattice : lattices) {
            lattice.map->ForSources(index, [&](size_t, double) { moves = true; });
          }
        }
      }
    }
    return moves;
  };
  std::vector<bool> tears(plan.seams.size());
  for (size_t n = 0; n < tears.size(); ++n) tears[n] = may_tear(plan.seams[n]);
  const auto is_torn = [&](uint32_t seam) { return seam != kNoIndex && tears[seam]; };
  return static_cast<uint64_t>(std::ranges::count_if(plan.patches, [&](const Patch& patch) {
    return std::ranges::any_of(patch.vertex,
                               [&](uint32_t v) { return is_torn(plan.vertices[v].seam); }) ||
           std::ranges::any_of(patch.edge, [&](uint32_t e) { return is_torn(plan.edges[e].seam); });
  }));
}

Bounds BoundsOf(const SceneState& state) {
  Bounds bounds;
  const DeformPlan& plan = *state.plan;
  const auto own = static_cast<size_t>(plan.structure.control_point_count());
  for (size_t i = 0; i < own; ++i) {
    if ((*state.influential)[i]) bounds.Extend((*state.control_points)[i]);
  }
  if (!plan.outside_bounds.empty()) bounds.Extend(plan.outside_bounds);
  // What turned lattices add lies in the hull of what they move their control points, or is nothing.
  for (const TurnedLattice& lattice : plan.turned) {
    Bounds moves;
    moves.Extend(Vec3d{});
    const auto count = static_cast<size_t>(lattice.structure.control_point_count());
    for (size_t i = lattice.first_point; i < lattice.first_point + count; ++i) {
      if (!(*state.influential)[i]) continue;
      moves.Extend((*state.control_points)[i] - plan.identity_points[i]);
    }
    bounds = {bounds.min + moves.min, bounds.max + moves.max};
  }
  // Weights draw points towards their places at rest.
  if (plan.is_weighted()) bounds.Extend(plan.mesh_bounds);
  return bounds;
}

absl::Time BusyUntil(absl::Time before, absl::Time edit_time) {
  // 40 ms is more than two frames of a display at 60 Hz. 80 ms leaves time to send full detail within 300 ms
  // of the last edit.
  constexpr absl::Duration kShortest = absl::Milliseconds(40), kLongest = absl::Milliseconds(80);
  return edit_time + std::clamp(1.5 * (edit_time - before), kShortest, kLongest);
}

}  // namespace latticed
