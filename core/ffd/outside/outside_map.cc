// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/outside/outside_map.h"

#include <algorithm>

#include "core/ffd/lattice_edit.h"

namespace latticed {
namespace {

using MapRow = OutsideMap::Row;

// One side of an axis, seen from its face outwards: distances are positive.
struct Continuation {
  std::vector<double>
      knots;  // what takes the place of the face's n + 1 knots; from the face outwards
  std::vector<MapRow> rows;  // what takes the place of the first control points, outermost first
  int replaced = 0;          // how many of those
};

double FallenOff(double distance) { return 1 - distance * distance * (3 - 2 * distance); }

// `span` is the first knot span inside; all are parameter distances.
Continuation ContinueSide(const Outside& outside, int degree, double width, double step,
                          double span) {
  const auto n = static_cast<size_t>(degree);
  Continuation side;
  if (width == 0) {
    side.knots.assign(n + 1, 0);
    return side;
  }
  const bool smooth = outside.mode == OutsideMode::kFalloff && outside.smooth && degree > 1;
  side.knots.assign(smooth ? n - 1 : n, 0);
  if (outside.mode == OutsideMode::kLinear) {
    for (int k = degree; k > 0; --k) {
      const double reach = k * width / span;
      side.rows.push_back({0, 2, {1 + reach, -reach}});
    }
  } else {
    side.knots.push_back(step);
    side.rows.assign(n, {});
    if (smooth) {
      side.rows.push_back({0, 2, {1 + step / span, -step / span}});
      side.replaced = 1;
    } else {
      side.rows.push_back({0, 1, {FallenOff(step / (degree * width))}});
    }
  }
  side.knots.insert(side.knots.end(), n + 1, width);
  return side;
}

// Continues one axis of the structure.
std::vector<MapRow> ContinueAxis(size_t axis, LatticeStructure& s) {
  const Outside& outside = s.outside;
  const std::vector<double> knots = s.knots[axis];
  const int degree = s.degree[axis], size = s.size[axis];
  const auto n = static_cast<size_t>(degree), count = static_cast<size_t>(size);
  const double begin = knots[n], end = knots[count], range = end - begin;
  const double before = outside.widths[SideOf(axis, false)];
  const double after = outside.widths[SideOf(axis, true)];
  const Continuation front =
      ContinueSide(outside, degree, before * range, outside.steps[SideOf(axis, false)] * range,
                   knots[n + 1] - begin);
  const Continuation back =
      ContinueSide(outside, degree, after * range, outside.steps[SideOf(axis, true)] * range,
                   end - knots[count - 1]);

  std::vector<MapRow> rows = front.rows;
  for (int i = front.replaced; i < size - back.replaced; ++i) rows.push_back({i, 1, {1}});
  for (auto row = back.rows.rbegin(); row != back.rows.rend(); ++row) {
    if (row->count == 2) {
      rows.push_back({size - 2, 2, {row->weight[1], row->weight[0]}});
    } else {
      rows.push_back({row->count == 0 ? 0 : size - 1, row->count, row->weight});
    }
  }
  if (before > 0 || after > 0) {
    auto& continued = s.knots[axis];
    continued.clear();
    for (auto knot = front.knots.rbegin(); knot != front.knots.rend(); ++knot) {
      continued.push_back(begin - *knot);
    }
    continued.insert(continued.end(), knots.begin() + degree + 1, knots.begin() + size);
    for (const double knot : back.knots) continued.push_back(end + knot);
    const Vec3d edge = s.frame.edges[axis];
    s.frame.origin -= before * edge;
    s.frame.edges[axis] = (1 + before + after) * edge;
    s.size[axis] = static_cast<int>(rows.size());
  }
  return rows;
}

}  // namespace

OutsideMap::OutsideMap(const LatticeStructure& structure, double strength)
    : structure_(structure), continued_(structure), strength_(strength) {
  for (size_t axis = 0; axis < 3; ++axis) rows_[axis] = ContinueAxis(axis, continued_);
  continued_.outside = {};
  is_identity_ = strength == 1 &&
                 std::ranges::all_of(structure.outside.widths, [](double w) { return w == 0; });
  if (is_identity_) return;
  rest_ = IdentityControlPoints(structure_);
  continued_rest_ = IdentityControlPoints(continued_);
}

std::vector<Vec3d> OutsideMap::Continue(std::span<const Vec3d> control_points) const {
  if (is_identity_) return {control_points.begin(), control_points.end()};
  std::vector<bool> moved(rest_.size());
  for (size_t i = 0; i < moved.size(); ++i) moved[i] = !SameBits(control_points[i], rest_[i]);
  std::vector<Vec3d> points = continued_rest_;
  for (size_t n = 0; n < points.size(); ++n) {
    Vec3d move;
    bool moves = false;
    ForSources(n, [&](size_t source, double weight) {
      if (!moved[source]) return;
      moves = true;
      move += weight * (control_points[source] - rest_[source]);
    });
    if (moves) points[n] += move;
  }
  return points;
}

std::vector<Vec3d> OutsideMap::Apply(std::span<const Vec3d> d) const {
  std::vector<Vec3d> result(static_cast<size_t>(continued_.control_point_count()));
  for (size_t n = 0; n < result.size(); ++n) {
    ForSources(n, [&](size_t source, double weight) { result[n] += weight * d[source]; });
  }
  return result;
}

std::vector<Vec3d> OutsideMap::ApplyTransposed(std::span<const Vec3d> g) const {
  std::vector<Vec3d> result(static_cast<size_t>(structure_.control_point_count()));
  for (size_t n = 0; n < g.size(); ++n) {
    ForSources(n, [&](size_t source, double weight) { result[source] += weight * g[n]; });
  }
  return result;
}

size_t OutsideMap::MemoryBytes() const {
  size_t bytes = (rest_.capacity() + continued_rest_.capacity()) * sizeof(Vec3d);
  for (const auto& rows : rows_) bytes += rows.capacity() * sizeof(MapRow);
  return bytes;
}

}  // namespace latticed
