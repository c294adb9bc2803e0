// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/trimming/trimmed_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace latticed::bench {
namespace {

constexpr double kSnap = 0x1p-40;  // as in the splitter

// Cuts the polygon at all rows, ascending, and each slab at all columns.
class Trimmer {
 public:
  explicit Trimmer(int segments)
      : segments_(segments),
        grid_points_(static_cast<size_t>((segments + 1) * (segments + 1)), kNone) {}

  TrimmedGrid Run(std::span<const TrimmedPoint> corners) {
    Polygon polygon;
    for (const TrimmedPoint& corner : corners) {
      polygon.push_back(Add(corner));
    }
    CutAtRows(std::move(polygon));
    Sort();
    return std::move(result_);
  }

 private:
  using Polygon = std::vector<uint16_t>;  // indices of points of the result
  using Coordinate = double TrimmedPoint::*;
  static constexpr uint16_t kNone = 0xffff;

  double Line(int index) const { return double{1} * index / segments_; }

  // The index of the grid line that x is on.
  std::optional<int> LineAt(double x) const {
    const auto nearest = static_cast<int>(std::lround(x * segments_));
    if (!(std::abs(x - Line(nearest)) <= kSnap)) return std::nullopt;
    return nearest;
  }

  // Adds each point of the grid only once, because every cell around it asks for it.
  uint16_t Add(TrimmedPoint point) {
    const auto column = LineAt(point.s), row = LineAt(point.t);
    if (column) point.s = Line(*column);
    if (row) point.t = Line(*row);
    if (!column || !row) return AddNew(point);
    uint16_t& known = grid_points_[static_cast<size_t>(*row * (segments_ + 1) + *column)];
    if (known == kNone) known = AddNew(point);
    return known;
  }
  uint16_t AddNew(TrimmedPoint point) {
    result_.points.push_back(point);
    return static_cast<uint16_t>(result_.points.size() - 1);
  }

  void CutAtRows(Polygon polygon) {
    for (int j = 1; j < segments_; ++j) {
      Polygon slab;
      if (!CutBelow(polygon, &TrimmedPoint::t, j, &slab)) continue;
      CutAtColumns(std::move(slab));
    }
    CutAtColumns(std::move(polygon));
  }

  void CutAtColumns(Polygon slab) {
    for (int i = 1; i < segments_; ++i) {
      Polygon cell;
      if (CutBelow(slab, &TrimmedPoint::s, i, &cell)) EmitFan(cell);
    }
    EmitFan(slab);
  }

  // Moves the part below a line out of `polygon`. Returns false if the line does not cross it.
  bool CutBelow(Polygon& polygon, Coordinate axis, int line, Polygon* below) {
    const double x = Line(line);
    const auto at = [&](uint16_t id) { return result_.points[id].*axis; };
    const auto [low, high] = std::minmax_element(
        polygon.begin(), polygon.end(), [&](uint16_t a, uint16_t b) { return at(a) < at(b); });
    if (!(at(*low) < x && x < at(*high))) return false;
    Polygon above;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const uint16_t from = polygon[i], to = polygon[(i + 1) % polygon.size()];
      const double a = at(from), b = at(to);
      if (a <= x) below->push_back(from);
      if (a >= x) above.push_back(from);
      if ((a < x && x < b) || (b < x && x < a)) {
        const uint16_t cut = Crossing(from, to, axis, line);
        below->push_back(cut);
        above.push_back(cut);
      }
    }
    polygon = std::move(above);
    return true;
  }

  uint16_t Crossing(uint16_t from, uint16_t to, Coordinate axis, int line) {
    const TrimmedPoint a = result_.points[from], b = result_.points[to];
    const double part = (Line(line) - a.*axis) / (b.*axis - a.*axis);
    TrimmedPoint cut{a.s + part * (b.s - a.s), a.t + part * (b.t - a.t)};
    cut.*axis = Line(line);
    return Add(cut);
  }

  void EmitFan(const Polygon& cell) {
    for (size_t k = 1; k + 1 < cell.size(); ++k) {
      const std::array<uint16_t, 3> triangle{cell[0], cell[k], cell[k + 1]};
      // In a narrow tip, several points can snap to one point of the grid.
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
        continue;
      }
      result_.triangles.push_back(triangle);
    }
  }

  void Sort() {
    const auto by_line = [](const TrimmedPoint& p) { return std::pair(p.t, p.s); };
    const std::vector<TrimmedPoint> points = result_.points;
    std::vector<uint16_t> order(points.size()), place(points.size());
    std::iota(order.begin(), order.end(), uint16_t{0});
    std::sort(order.begin(), order.end(),
              [&](uint16_t a, uint16_t b) { return by_line(points[a]) < by_line(points[b]); });
    for (size_t i = 0; i < order.size(); ++i) {
      result_.points[i] = points[order[i]];
      place[order[i]] = static_cast<uint16_t>(i);
    }
    for (auto& triangle : result_.triangles) {
      for (uint16_t& id : triangle) id = place[id];
    }
  }

  int segments_;
  std::vector<uint16_t> grid_points_;  // points where a row and a column cross
  TrimmedGrid result_;
};

}  // namespace

TrimmedGrid TrimGrid(std::span<const TrimmedPoint> polygon, int segments) {
  return Trimmer(segments).Run(polygon);
}

}  // namespace latticed::bench
