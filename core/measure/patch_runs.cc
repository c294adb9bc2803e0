// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_runs.h"

#include <numeric>

#include "core/ffd/direct_ffd.h"

namespace latticed {
namespace {

Vec3d PointOfSurface(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  constexpr double kThird = 1.0 / 3;
  return DirectFfd(plan, control_points).EvaluatePosition(0, {kThird, kThird, kThird}).position;
}

}  // namespace

PatchRuns::PatchRuns(const DeformPlan& plan, std::span<const Vec3d> control_points)
    : plan_(plan),
      control_points_(control_points),
      origin_(PointOfSurface(plan, control_points)),
      order_(plan.patches.size()) {
  boxes_.emplace_back(plan.structure);
  for (const TurnedLattice& lattice : plan.turned) boxes_.emplace_back(lattice.structure);
  std::iota(order_.begin(), order_.end(), 0u);
  // They are sorted by the boxes of the plan's own lattice already.
  for (size_t box = 0; box + 1 < plan.box_patches.size() && !plan.turned.empty(); ++box) {
    const auto first = order_.begin() + plan.box_patches[box];
    std::stable_sort(first, order_.begin() + plan.box_patches[box + 1],
                     [&](uint32_t a, uint32_t b) {
                       for (const TurnedLattice& lattice : plan.turned) {
                         if (lattice.spans[a] != lattice.spans[b])
                           return lattice.spans[a] < lattice.spans[b];
                       }
                       return false;
                     });
  }
  const auto together = [&](uint32_t a, uint32_t b) {
    return plan.patches[a].box == plan.patches[b].box &&
           std::ranges::all_of(plan.turned, [&](const TurnedLattice& lattice) {
             return lattice.spans[a] == lattice.spans[b];
           });
  };
  for (size_t i = 0; i < order_.size(); ++i) {
    if (begins_.empty() || i - begins_.back() == kPatchesPerRun ||
        !together(order_[i - 1], order_[i])) {
      begins_.push_back(i);
    }
  }
  begins_.push_back(order_.size());
}

KnotSpans PatchRuns::SpansOf(size_t lattice, size_t patch) const {
  if (lattice > 0) return plan_.turned[lattice - 1].spans[patch];
  const uint32_t box = plan_.patches[patch].box;
  return box == plan_.outside_box() ? kNoSpans : plan_.boxes[box].span;
}

std::vector<RunLattice> PatchRuns::LatticesOf(size_t run) const {
  std::vector<RunLattice> lattices;
  for (size_t g = 0; g < boxes_.size(); ++g) {
    const KnotSpans spans = SpansOf(g, patches(run).front());
    if (spans == kNoSpans) continue;
    RunLattice lattice{.boxes = &boxes_[g], .box = boxes_[g].BoxOf(spans)};
    if (g > 0) lattice.first_point = plan_.turned[g - 1].first_point;
    lattice.map = boxes_[g].MapOf(lattice.box);
    lattice.map.frame_origin -= origin_;
    lattice.polynomial =
        boxes_[g].PolynomialOf(lattice.box, control_points_.subspan(lattice.first_point));
    lattice.polynomial.origin -= origin_;
    lattices.push_back(lattice);
  }
  return lattices;
}

RestTriangle PatchRuns::TriangleOf(size_t patch) const {
  const auto& v = plan_.patches[patch].vertex;
  RestTriangle triangle{.corner = plan_.vertices[v[0]].world - origin_};
  triangle.s = plan_.vertices[v[1]].world - origin_ - triangle.corner;
  triangle.t = plan_.vertices[v[2]].world - origin_ - triangle.corner;
  if (plan_.is_weighted()) {
    const std::array<double, 3> weights = plan_.CornerWeights(patch);
    triangle.weight = weights[0];
    triangle.weight_s = weights[1] - weights[0];
    triangle.weight_t = weights[2] - weights[0];
  }
  return triangle;
}

}  // namespace latticed
