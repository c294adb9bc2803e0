// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/outside/outside_map.h"

#include <algorithm>
#include <map>
#include <utility>

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

// The rows of `refined`, whose columns are the rows of `rows`, as rows over the columns of `rows`.
std::vector<MapRow> Composed(const std::vector<RefinedPoint>& refined,
                             const std::vector<MapRow>& rows) {
  std::vector<MapRow> result;
  for (const RefinedPoint& point : refined) {
    std::map<int, double> sum;
    for (int i = 0; i < point.count; ++i) {
      const MapRow& row = rows[static_cast<size_t>(point.first + i)];
      for (int j = 0; j < row.count; ++j) {
        sum[row.first + j] +=
            point.weight[static_cast<size_t>(i)] * row.weight[static_cast<size_t>(j)];
      }
    }
    std::erase_if(sum, [](const auto& entry) { return entry.second == 0; });
    MapRow& row = result.emplace_back();
    if (sum.empty()) continue;
    row.first = sum.begin()->first;
    row.count = sum.rbegin()->first - row.first + 1;
    for (const auto& [column, weight] : sum) {
      row.weight[static_cast<size_t>(column - row.first)] = weight;
    }
  }
  return result;
}

using GridSize = std::array<size_t, 3>;

GridSize SizeOf(const LatticeStructure& s) {
  return {static_cast<size_t>(s.size[0]), static_cast<size_t>(s.size[1]),
          static_cast<size_t>(s.size[2])};
}

// How far apart neighbours along the axis are.
size_t StrideOf(size_t axis, const GridSize& grid) {
  return axis == 0 ? 1 : axis == 1 ? grid[0] : grid[0] * grid[1];
}

// Calls add(line of E_a's result, line of its argument, weight) for the numbers of E_a in each layer of a grid. A line is what
// one control point along the axis has in the layer; before E_a there are `columns` of them.
template <typename Add>
void ForNumbers(const std::vector<MapRow>& rows, size_t columns, size_t layers, Add add) {
  for (size_t layer = 0; layer < layers; ++layer) {
    for (size_t r = 0; r < rows.size(); ++r) {
      const size_t first = layer * columns + static_cast<size_t>(rows[r].first);
      for (size_t i = 0; i < static_cast<size_t>(rows[r].count); ++i) {
        add(layer * rows.size() + r, first + i, rows[r].weight[i]);
      }
    }
  }
}

void AddLine(double weight, const Vec3d* from, size_t count, Vec3d* to) {
  for (size_t x = 0; x < count; ++x) to[x] += weight * from[x];
}

// Applies E_a along an axis of a grid, u fastest.
std::vector<Vec3d> Along(size_t axis, const std::vector<MapRow>& rows, const GridSize& grid,
                         const std::vector<Vec3d>& d) {
  const size_t stride = StrideOf(axis, grid), layers = d.size() / grid[axis] / stride;
  std::vector<Vec3d> result(layers * rows.size() * stride);
  ForNumbers(rows, grid[axis], layers, [&](size_t row, size_t column, double weight) {
    AddLine(weight, &d[column * stride], stride, &result[row * stride]);
  });
  return result;
}

// Applies E_a' to what Along returns.
std::vector<Vec3d> AlongTransposed(size_t axis, const std::vector<MapRow>& rows,
                                   const GridSize& grid, size_t columns,
                                   const std::vector<Vec3d>& g) {
  const size_t stride = StrideOf(axis, grid), layers = g.size() / grid[axis] / stride;
  std::vector<Vec3d> result(layers * columns * stride);
  ForNumbers(rows, columns, layers, [&](size_t row, size_t column, double weight) {
    AddLine(weight, &g[row * stride], stride, &result[column * stride]);
  });
  return result;
}

}  // namespace

OutsideMap::OutsideMap(const LatticeStructure& structure, double strength)
    : structure_(structure), continued_(structure), strength_(strength) {
  for (size_t axis = 0; axis < 3; ++axis) rows_[axis] = ContinueAxis(axis, continued_);
  continued_.outside = {};
  goes_on_ = std::ranges::any_of(structure.outside.widths, [](double w) { return w != 0; });
  TakeRest();
}

void OutsideMap::TakeRest() {
  is_identity_ = strength_ == 1 && !goes_on_;
  if (is_identity_) return;
  rest_ = IdentityControlPoints(structure_);
  continued_rest_.clear();
  if (plan_rest_ == nullptr) continued_rest_ = IdentityControlPoints(continued_);
}

void OutsideMap::PlaceAmong(size_t first, std::shared_ptr<const std::vector<Vec3d>> rest) {
  first_ = first;
  plan_rest_ = std::move(rest);
  goes_on_ = true;
  TakeRest();
}

size_t OutsideMap::planned_count() const {
  return plan_rest_ != nullptr ? plan_rest_->size()
                               : static_cast<size_t>(continued_.control_point_count());
}

OutsideMap OutsideMap::At(double strength) const {
  OutsideMap map = *this;
  map.strength_ = strength;
  map.TakeRest();
  return map;
}

OutsideMap::OutsideMap(const LatticeStructure& structure, double strength,
                       const LatticeStructure& sum, const RefinedAxes& refined)
    : OutsideMap(structure, strength) {
  for (size_t axis = 0; axis < 3; ++axis) rows_[axis] = Composed(refined[axis], rows_[axis]);
  continued_ = sum;
  goes_on_ = true;
  TakeRest();
}

std::vector<Vec3d> OutsideMap::Continue(std::span<const Vec3d> control_points) const {
  if (is_identity_) return {control_points.begin(), control_points.end()};
  std::vector<Vec3d> moves = Moves(control_points);
  if (others_ == nullptr) return Moved(moves);
  for (size_t n = 0; n < moves.size(); ++n) moves[n] += (*others_)[n];
  return Moved(moves);
}

std::vector<Vec3d> OutsideMap::Moves(std::span<const Vec3d> control_points) const {
  std::vector<Vec3d> d(control_points.begin(), control_points.end());
  for (size_t i = 0; i < d.size(); ++i) d[i] -= rest_[i];
  return Apply(d);
}

std::vector<Vec3d> OutsideMap::Moved(std::span<const Vec3d> moves) const {
  std::vector<Vec3d> points = plan_rest_ != nullptr ? *plan_rest_ : continued_rest_;
  for (size_t n = 0; n < points.size(); ++n) {
    if (moves[n] != Vec3d{}) points[n] += moves[n];
  }
  return points;
}

std::vector<Vec3d> OutsideMap::Apply(std::span<const Vec3d> d) const {
  const GridSize grid = SizeOf(structure_);
  std::vector<Vec3d> result = Along(0, rows_[0], grid, {d.begin(), d.end()});
  result = Along(1, rows_[1], {rows_[0].size(), grid[1], grid[2]}, result);
  result = Along(2, rows_[2], {rows_[0].size(), rows_[1].size(), grid[2]}, result);
  if (strength_ != 1) {
    for (Vec3d& p : result) p = strength_ * p;
  }
  if (plan_rest_ == nullptr) return result;
  std::vector<Vec3d> planned(planned_count());
  std::ranges::copy(result, planned.begin() + static_cast<ptrdiff_t>(first_));
  return planned;
}

std::vector<Vec3d> OutsideMap::ApplyTransposed(std::span<const Vec3d> g) const {
  const GridSize given = SizeOf(structure_), grid = SizeOf(continued_);
  g = g.subspan(first_, static_cast<size_t>(continued_.control_point_count()));
  std::vector<Vec3d> result = AlongTransposed(2, rows_[2], grid, given[2], {g.begin(), g.end()});
  result = AlongTransposed(1, rows_[1], {grid[0], grid[1], given[2]}, given[1], result);
  result = AlongTransposed(0, rows_[0], {grid[0], given[1], given[2]}, given[0], result);
  if (strength_ != 1) {
    for (Vec3d& p : result) p = strength_ * p;
  }
  return result;
}

std::shared_ptr<const OutsideMap> WithStrength(const std::shared_ptr<const OutsideMap>& map,
                                               double strength) {
  if (map->strength() == strength) return map;
  return std::make_shared<const OutsideMap>(map->At(strength));
}

size_t OutsideMap::MemoryBytes() const {
  size_t bytes = (rest_.capacity() + continued_rest_.capacity()) * sizeof(Vec3d);
  for (const auto& rows : rows_) bytes += rows.capacity() * sizeof(MapRow);
  return bytes;
}

}  // namespace latticed
