// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/turned/turned_lattice.h"

#include <algorithm>
#include <optional>

#include "core/ffd/box/volume_point.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/direct_ffd.h"

namespace latticed {
namespace {

Vec3d BlendCorners(const std::array<Vec3d, 3>& v, const std::array<double, 3>& b) {
  return b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
}

}  // namespace

KnotSpans LowerSpans(const LatticeStructure& s, std::span<const Vec3d> parameters) {
  KnotSpans spans;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    double highest = parameters[0][axis];
    for (const Vec3d p : parameters) {
      if (p[axis] < s.domain_begin(axis) || p[axis] > s.domain_end(axis)) return kNoSpans;
      highest = std::max(highest, p[axis]);
    }
    spans[a] = FindLowerSpan(s.knots[a].data(), s.degree[a], s.size[a], highest);
  }
  return spans;
}

std::optional<PointRange> TurnedLattice::Reaching(size_t vertex) const {
  PointRange range;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    const double u = parameters[vertex][axis];
    if (u < structure.domain_begin(axis) || u > structure.domain_end(axis)) return std::nullopt;
    const std::vector<double>& knots = structure.knots[a];
    const auto order = static_cast<size_t>(structure.degree[a]) + 1;
    size_t first = 0, last = static_cast<size_t>(structure.size[a]) - 1;
    while (knots[first + order] < u) ++first;
    while (knots[last] > u) --last;
    range.first[a] = static_cast<int>(first);
    range.last[a] = static_cast<int>(last);
  }
  return range;
}

TurnedMoves::TurnedMoves(std::span<const TurnedLattice> lattices,
                         std::span<const Vec3d> control_points)
    : lattices_(lattices), control_points_(control_points) {
  for (const TurnedLattice& lattice : lattices) {
    parameter_by_world_.push_back(ParameterByWorld(lattice.structure));
  }
}

TurnedMove TurnedMoves::OfPatch(size_t patch, const std::array<uint32_t, 3>& vertices,
                                const std::array<double, 3>& b, Vec3d world) const {
  TurnedMove sum;
  for (size_t g = 0; g < lattices_.size(); ++g) {
    const TurnedLattice& lattice = lattices_[g];
    const KnotSpans& spans = lattice.spans[patch];
    if (spans == kNoSpans) continue;
    const Vec3d parameter =
        BlendCorners({lattice.parameters[vertices[0]], lattice.parameters[vertices[1]],
                      lattice.parameters[vertices[2]]},
                     b);
    sum.Add(EvaluateVolume(lattice.structure, lattice.PointsOf(control_points_), spans, parameter),
            parameter_by_world_[g], world);
  }
  return sum;
}

Vec3d TurnedMoves::OnEdge(uint32_t a, uint32_t b, double t, Vec3d world) const {
  Vec3d sum;
  for (const TurnedLattice& lattice : lattices_) {
    const std::array ends{lattice.parameters[a], lattice.parameters[b]};
    const KnotSpans spans = LowerSpans(lattice.structure, ends);
    if (spans == kNoSpans) continue;
    const Vec3d parameter = (1 - t) * ends[0] + t * ends[1];
    sum += EvaluateVolumePosition(lattice.structure, lattice.PointsOf(control_points_), spans,
                                  parameter) -
           world;
  }
  return sum;
}

void TurnedMove::Add(const VolumePoint& point, const std::array<Vec3d, 3>& parameter_by_world,
                     Vec3d world) {
  move += point.position - world;
  std::array<Vec3d, 3> own;
  WorldJacobian(point.derivatives, parameter_by_world.data(), own.data());
  for (size_t axis = 0; axis < 3; ++axis) {
    jacobian[axis] += own[axis];
    jacobian[axis][static_cast<int>(axis)] -= 1;
  }
}

TurnedMove TurnedMoveAt(std::span<const TurnedLattice> lattices,
                        std::span<const Vec3d> control_points, Vec3d world) {
  TurnedMove sum;
  for (const TurnedLattice& lattice : lattices) {
    const auto place = FindVolumePlace(lattice.structure, world);
    if (!place.has_value()) continue;
    sum.Add(EvaluateVolume(lattice.structure, lattice.PointsOf(control_points), place->span,
                           place->parameter),
            ParameterByWorld(lattice.structure), world);
  }
  return sum;
}

}  // namespace latticed
