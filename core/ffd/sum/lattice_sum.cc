// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/sum/lattice_sum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/outside/outside_map.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOneKnot = 0x1p-40;  // of the range of an axis

// One axis of one lattice as it is continued, in the parameter of the first lattice.
struct SummandAxis {
  AxisSpace space;
  bool fades_at_begin = false, fades_at_end = false;
};

struct AxisEnds {
  double begin = kInfinity, end = -kInfinity;
};

// Axis `a` of `continued`, of which `given` is the inside.
SummandAxis AxisOf(const LatticeStructure& given, const LatticeStructure& continued,
                   const FrameMap& first, size_t a) {
  const auto axis = static_cast<int>(a);
  const Vec3d edge = first.DirectionToParameter(continued.frame.edges[a]);
  const double at = first.ToParameter(continued.frame.origin)[axis];
  const double begin = continued.domain_begin(axis);
  const double scale = edge[axis] / (continued.domain_end(axis) - begin);
  SummandAxis result{{continued.degree[a], continued.knots[a]}};
  for (double& knot : result.space.knots) knot = at + scale * (knot - begin);
  const bool fades = given.outside.mode == OutsideMode::kFalloff;
  result.fades_at_begin = fades && given.outside.widths[SideOf(a, false)] > 0;
  result.fades_at_end = fades && given.outside.widths[SideOf(a, true)] > 0;
  return result;
}

AxisEnds ExtentOf(std::span<const Vec3d> mesh, const FrameMap& first, size_t a) {
  AxisEnds extent;
  for (const Vec3d p : mesh) {
    const double x = first.ToParameter(p)[static_cast<int>(a)];
    extent.begin = std::min(extent.begin, x);
    extent.end = std::max(extent.end, x);
  }
  return extent;
}

// Where the sum ends: at the nearest end, beyond the mesh, of a lattice that does not fade out there, or else at the last end of
// all. Of ends that are almost equal, that of the first lattice counts.
AxisEnds EndsOf(std::span<const SummandAxis> axes, const AxisEnds& mesh) {
  const double near = kOneKnot * (axes.front().space.end() - axes.front().space.begin());
  AxisEnds all, beyond{-kInfinity, kInfinity};
  for (const SummandAxis& axis : axes) {
    const double begin = axis.space.begin(), end = axis.space.end();
    all = {std::min(all.begin, begin), std::max(all.end, end)};
    if (begin <= mesh.begin + near && !axis.fades_at_begin) {
      beyond.begin = std::max(beyond.begin, begin);
    }
    if (end >= mesh.end - near && !axis.fades_at_end) beyond.end = std::min(beyond.end, end);
  }
  AxisEnds ends{std::isinf(beyond.begin) ? all.begin : beyond.begin,
                std::isinf(beyond.end) ? all.end : beyond.end};
  for (size_t k = axes.size(); k-- > 0;) {
    const AxisSpace& space = axes[k].space;
    if (std::abs(space.begin() - ends.begin) <= near) ends.begin = space.begin();
    if (std::abs(space.end() - ends.end) <= near) ends.end = space.end();
  }
  return ends;
}

// `near`: two ends that differ by no more are one.
absl::Status CheckEnds(size_t k, const SummandAxis& axis, const AxisEnds& ends, double near,
                       size_t a) {
  const bool begins_inside = axis.space.begin() > ends.begin + near && !axis.fades_at_begin;
  const bool ends_inside = axis.space.end() < ends.end - near && !axis.fades_at_end;
  if (!begins_inside && !ends_inside) return absl::OkStatus();
  constexpr std::array<std::string_view, 3> kNames{"u", "v", "w"};
  return error::InvalidField(
      fmt::format("lattices[{}].outside", k),
      fmt::format("the lattice ends inside the mesh, at the {} of {}, where another goes on: give "
                  "it FALLOFF with a width there, or a larger frame",
                  begins_inside ? "begin" : "end", kNames[a]));
}

// The places of all knots between the ends, ascending. Of those that are almost equal, that of the first lattice.
std::vector<double> PlacesOfKnots(std::span<const SummandAxis> axes, const AxisEnds& ends) {
  const double near = kOneKnot * (ends.end - ends.begin);
  std::vector<std::pair<double, size_t>> knots;  // with the index of the lattice
  for (size_t k = 0; k < axes.size(); ++k) {
    for (const double knot : axes[k].space.knots) {
      if (knot > ends.begin + near && knot < ends.end - near) knots.emplace_back(knot, k);
    }
  }
  std::ranges::sort(knots);
  std::vector<double> places;
  for (size_t i = 0; i < knots.size();) {
    size_t j = i, chosen = i;
    for (; j < knots.size() && knots[j].first <= knots[i].first + near; ++j) {
      if (knots[j].second < knots[chosen].second) chosen = j;
    }
    places.push_back(knots[chosen].first);
    i = j;
  }
  return places;
}

// Moves knots to the places that they almost have.
void Snap(const std::vector<double>& places, double near, std::vector<double>& knots) {
  for (double& knot : knots) {
    const auto next = std::ranges::lower_bound(places, knot - near);
    if (next != places.end() && *next <= knot + near) knot = *next;
  }
}

// How often the sum of degree `degree` must have the knot, so that it can be this lattice. 0: it need not.
int MultiplicityFor(const AxisSpace& space, double knot, int degree) {
  const auto [first, last] = std::equal_range(space.knots.begin(), space.knots.end(), knot);
  const bool is_end = knot == space.begin() || knot == space.end();
  const bool is_inside = knot > space.begin() && knot < space.end() && first != last;
  if (!is_end && !is_inside) return 0;
  const auto own = is_end ? 1 : std::min(static_cast<int>(last - first), space.degree);
  return degree - space.degree + own;
}

// The smallest space between the ends that contains all lattices. Moves their knots to those of the sum.
AxisSpace SpaceOf(std::span<SummandAxis> axes, const AxisEnds& ends) {
  std::vector<double> places = PlacesOfKnots(axes, ends);
  places.insert(places.begin(), ends.begin);
  places.push_back(ends.end);
  AxisSpace sum;
  for (SummandAxis& axis : axes) {
    Snap(places, kOneKnot * (ends.end - ends.begin), axis.space.knots);
    sum.degree = std::max(sum.degree, axis.space.degree);
  }
  for (const double place : places) {
    int multiplicity = place == ends.begin || place == ends.end ? sum.degree + 1 : 0;
    for (const SummandAxis& axis : axes) {
      multiplicity = std::max(multiplicity, MultiplicityFor(axis.space, place, sum.degree));
    }
    sum.knots.insert(sum.knots.end(), static_cast<size_t>(multiplicity), place);
  }
  return sum;
}

// Sums one axis of all members, and sets it in `sum`.
absl::Status SumAxis(size_t a, std::vector<SummandAxis>& axes, const AxisEnds& mesh,
                     std::span<const size_t> members, bool has_others, LatticeSum& sum) {
  const AxisEnds ends = EndsOf(axes, mesh);
  AxisEnds least = ends;
  if (has_others) least = {std::min(ends.begin, mesh.begin), std::max(ends.end, mesh.end)};
  for (size_t k = 0; k < axes.size(); ++k) {
    LATTICED_RETURN_IF_ERROR(
        CheckEnds(members[k], axes[k], least, kOneKnot * (ends.end - ends.begin), a));
  }
  const AxisSpace space = SpaceOf(axes, ends);
  for (size_t k = 0; k < axes.size(); ++k) sum.parts[k][a] = Refine(axes[k].space, space);
  sum.structure.degree[a] = space.degree;
  sum.structure.size[a] = space.size();
  sum.structure.knots[a] = space.knots;
  return absl::OkStatus();
}

}  // namespace

bool AreParallel(const LatticeStructure& first, const LatticeStructure& other) {
  constexpr double kParallel = 1e-9;
  const FrameMap map(first);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3d edge = map.DirectionToParameter(other.frame.edges[static_cast<size_t>(axis)]);
    for (int b = 0; b < 3; ++b) {
      if (b != axis && !(std::abs(edge[b]) <= kParallel * edge[axis])) return false;
    }
  }
  return true;
}

absl::StatusOr<LatticeSum> SumLattices(std::span<const LatticeStructure> lattices,
                                       std::span<const Vec3d> mesh,
                                       std::span<const size_t> members) {
  const LatticeStructure& one = lattices[members.front()];
  const FrameMap first(one);
  LatticeSum sum;
  sum.parts.resize(members.size());
  int64_t count = 1;
  std::array<double, 3> begin{}, range{};
  for (size_t a = 0; a < 3; ++a) {
    std::vector<SummandAxis> axes;
    for (const size_t k : members) {
      const LatticeStructure continued = OutsideMap(lattices[k]).continued();
      axes.push_back(AxisOf(lattices[k], continued, first, a));
      // The first lattice's own knots, not rounded on their way through the world.
      if (axes.size() == 1) axes[0].space.knots = continued.knots[a];
    }
    LATTICED_RETURN_IF_ERROR(
        SumAxis(a, axes, ExtentOf(mesh, first, a), members, members.size() < lattices.size(), sum));
    count *= sum.structure.size[a];
    begin[a] = sum.structure.domain_begin(static_cast<int>(a));
    range[a] = sum.structure.domain_end(static_cast<int>(a)) - begin[a];
  }
  if (count > limits::kMaxControlPoints) {
    return error::InvalidField(
        "lattices", fmt::format("their sum has {} control points, at most {} are allowed", count,
                                limits::kMaxControlPoints));
  }
  sum.structure.frame.origin = first.ToWorld({begin[0], begin[1], begin[2]});
  for (size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    const double share = range[a] / (one.domain_end(axis) - one.domain_begin(axis));
    sum.structure.frame.edges[a] = share * one.frame.edges[a];
  }
  return sum;
}

}  // namespace latticed
