// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/patch_sums.h"

#include <algorithm>

namespace latticed {
namespace {

using patch_sums::Rest;
using patch_sums::Volume;

std::vector<Vec3d> Relative(std::span<const Vec3d> points, Vec3d origin) {
  std::vector<Vec3d> relative(points.begin(), points.end());
  for (Vec3d& p : relative) p -= origin;
  return relative;
}

}  // namespace

PatchSums::PatchSums(const DeformPlan& plan, std::span<const Vec3d> control_points)
    : plan_(plan),
      control_points_(Relative(control_points, plan.local_origin)),
      own_{plan.structure, FrameMap(plan.structure), control_points_} {
  for (const TurnedLattice& lattice : plan.turned) {
    turned_.push_back({lattice.structure, FrameMap(lattice.structure),
                       std::span(control_points_).subspan(lattice.first_point)});
  }
}

void PatchSums::Evaluate(size_t index, const patch_sums::Places& places,
                         std::span<const Vec3d> directions, patch_sums::Values& values) const {
  const Patch& patch = plan_.patches[index];
  Rest rest;
  rest.direction_count = directions.size();
  std::ranges::copy(directions, rest.directions.begin());
  for (size_t c = 0; c < 3; ++c) {
    rest.corners[c] = plan_.vertices[patch.vertex[c]].world - plan_.local_origin;
  }
  if (patch.box == plan_.outside_box()) {
    SetRest(places, rest, values);
  } else {
    Volume volume = VolumeOf(own_, plan_.boxes[patch.box].span, rest);
    for (size_t c = 0; c < 3; ++c) {
      volume.parameters[c] = plan_.vertices[patch.vertex[c]].parameter;
    }
    SetVolume(places, volume, rest, values);
  }
  for (size_t g = 0; g < turned_.size(); ++g) {
    const TurnedLattice& lattice = plan_.turned[g];
    if (lattice.spans[index] == kNoSpans) continue;
    Volume volume = VolumeOf(turned_[g], lattice.spans[index], rest);
    for (size_t c = 0; c < 3; ++c) volume.parameters[c] = lattice.parameters[patch.vertex[c]];
    AddVolume(places, volume, rest, values);
  }
  if (!plan_.is_weighted()) return;
  patch_sums::Weights weights{.corners = plan_.CornerWeights(index)};
  if (!directions.empty()) {
    const Vec3d gradient = plan_.PatchWeightGradient(index);
    for (size_t k = 0; k < directions.size(); ++k) weights.along[k] = Dot(gradient, directions[k]);
  }
  Weigh(places, weights, rest, values);
}

Volume PatchSums::VolumeOf(const Lattice& lattice, const std::array<int, 3>& spans,
                           const Rest& rest) {
  const LatticeStructure& s = lattice.structure;
  Volume volume;
  volume.degree = s.degree;
  for (size_t a = 0; a < 3; ++a) volume.span[a] = s.knots[a].data() + spans[a];
  for (size_t k = 0; k < rest.direction_count; ++k) {
    volume.directions[k] = lattice.map.DirectionToParameter(rest.directions[k]);
  }
  const std::array<int, 3> first{spans[0] - s.degree[0], spans[1] - s.degree[1],
                                 spans[2] - s.degree[2]};
  volume.origin =
      lattice.control_points[static_cast<size_t>(s.Index(first[0], first[1], first[2]))];
  double* to = volume.points.data();
  for (int k = first[2]; k <= spans[2]; ++k) {
    for (int j = first[1]; j <= spans[1]; ++j) {
      const Vec3d* row = &lattice.control_points[static_cast<size_t>(s.Index(first[0], j, k))];
      for (int i = 0; i <= s.degree[0]; ++i) {
        const Vec3d point = row[i] - volume.origin;
        for (int c = 0; c < 3; ++c) *to++ = point[c];
      }
    }
  }
  return volume;
}

}  // namespace latticed
