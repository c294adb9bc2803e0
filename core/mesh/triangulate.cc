// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/triangulate.h"

#include <algorithm>
#include <cmath>

namespace latticed {
namespace {

struct Point {
  double x = 0, y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

// Twice the signed area of abc; positive when counter-clockwise.
double Orient(Point a, Point b, Point c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon in its plane of best fit, counter-clockwise, relative to its first corner and scaled
// to a largest coordinate of 1: a distant or huge polygon keeps its digits and no product
// overflows.
std::vector<Point> Project(std::span<const Vec3d> polygon) {
  std::vector<Vec3d> local(polygon.size());
  double scale = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    local[i] =
        0.5 * polygon[i] - 0.5 * polygon[0];  // halved: the difference of two finite numbers fits
    scale = std::max({scale, std::abs(local[i].x), std::abs(local[i].y), std::abs(local[i].z)});
  }
  std::vector<Point> points(polygon.size());
  if (scale == 0) return points;
  for (Vec3d& p : local) p = p / scale;

  Vec3d normal = NewellNormal(local);
  const double length = Norm(normal);
  normal = length > 0 ? normal / length : Vec3d{0, 0, 1};
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(normal[i]) < std::abs(normal[axis])) axis = i;
  }
  Vec3d e;
  e[axis] = 1;
  Vec3d tangent = Cross(e, normal);
  tangent = tangent / Norm(tangent);
  const Vec3d bitangent = Cross(normal, tangent);
  for (size_t i = 0; i < local.size(); ++i) {
    points[i] = {Dot(local[i], tangent), Dot(local[i], bitangent)};
  }
  return points;
}

// The corners that may lie in an ear, in the cells of a uniform grid. A small polygon has one cell.
class CornerGrid {
 public:
  explicit CornerGrid(const std::vector<Point>& points) : points_(points) {
    constexpr size_t kCornersPerCell = 4;
    const size_t cells = points.size() / kCornersPerCell;
    side_ = std::max<size_t>(1, static_cast<size_t>(std::sqrt(static_cast<double>(cells))));
    low_ = high_ = points[0];
    for (Point p : points) {
      low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
      high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
    }
    cells_.resize(side_ * side_);
  }

  void Add(uint32_t corner) { Cell(points_[corner]).push_back(corner); }
  void Remove(uint32_t corner) { std::erase(Cell(points_[corner]), corner); }

  // Whether `test` holds for any corner in the cells that the box of a, b, c touches.
  template <typename Test>
  bool AnyOf(Point a, Point b, Point c, const Test& test) const {
    const size_t x0 = Column(std::min({a.x, b.x, c.x})), x1 = Column(std::max({a.x, b.x, c.x}));
    const size_t y0 = Row(std::min({a.y, b.y, c.y})), y1 = Row(std::max({a.y, b.y, c.y}));
    for (size_t y = y0; y <= y1; ++y) {
      for (size_t x = x0; x <= x1; ++x) {
        const std::vector<uint32_t>& cell = cells_[y * side_ + x];
        if (std::any_of(cell.begin(), cell.end(), test)) return true;
      }
    }
    return false;
  }

 private:
  size_t Slot(double value, double low, double high) const {
    if (!(high > low)) return 0;
    const double slot = (value - low) / (high - low) * static_cast<double>(side_);
    return std::min(static_cast<size_t>(std::max(slot, 0.0)), side_ - 1);
  }
  size_t Column(double x) const { return Slot(x, low_.x, high_.x); }
  size_t Row(double y) const { return Slot(y, low_.y, high_.y); }
  std::vector<uint32_t>& Cell(Point p) { return cells_[Row(p.y) * side_ + Column(p.x)]; }

  const std::vector<Point>& points_;
  size_t side_ = 1;
  Point low_, high_;
  std::vector<std::vector<uint32_t>> cells_;
};

class EarClipper {
 public:
  EarClipper(const std::vector<Point>& points, std::vector<std::array<uint32_t, 3>>* triangles)
      : points_(points), grid_(points), triangles_(*triangles) {
    const auto n = static_cast<uint32_t>(points.size());
    previous_.resize(n);
    next_.resize(n);
    blocking_.resize(n);
    for (uint32_t i = 0; i < n; ++i) {
      previous_[i] = (i + n - 1) % n;
      next_[i] = (i + 1) % n;
    }
    for (uint32_t i = 0; i < n; ++i) UpdateBlocking(i);
  }

  void Run() {
    auto left = static_cast<uint32_t>(points_.size());
    uint32_t corner = 0;
    uint32_t tried = 0;
    while (left > 3) {
      if (!IsEar(corner)) {
        corner = next_[corner];
        if (++tried < left) continue;
        corner = LeastBadCorner(corner);
      }
      const uint32_t after = next_[corner];
      Clip(corner);
      --left;
      tried = 0;
      corner = next_[after];  // not `after`: skipping one keeps the triangles from forming a fan
    }
    triangles_.push_back({previous_[corner], corner, next_[corner]});
  }

 private:
  // Doubled area, in the unit box of Project, below which a corner counts as flat: rounding of the
  // projection.
  static constexpr double kFlat = 4e-15;

  double Area(uint32_t i) const {
    return Orient(points_[previous_[i]], points_[i], points_[next_[i]]);
  }

  bool IsEar(uint32_t i) const {
    if (blocking_[i]) return false;
    const uint32_t before = previous_[i], after = next_[i];
    const Point a = points_[before], b = points_[i], c = points_[after];
    return !grid_.AnyOf(a, b, c, [&](uint32_t p) {
      return p != before && p != i && p != after && Blocks(p, a, b, c);
    });
  }

  // Whether corner p lies in the triangle abc, its edges included. A corner at the place of a, b or
  // c (a bridge to a hole doubles corners) blocks only if the polygon goes from there into the
  // triangle.
  bool Blocks(uint32_t p, Point a, Point b, Point c) const {
    const Point q = points_[p];
    if (q == a) return EntersWedge(p, c, a, b);
    if (q == b) return EntersWedge(p, a, b, c);
    if (q == c) return EntersWedge(p, b, c, a);
    return Orient(a, b, q) >= -kFlat && Orient(b, c, q) >= -kFlat && Orient(c, a, q) >= -kFlat;
  }

  // Whether an edge at p, which lies on apex, points strictly between apex→left and apex→right,
  // with right counter-clockwise before left.
  bool EntersWedge(uint32_t p, Point left, Point apex, Point right) const {
    const auto inside = [&](Point q) {
      return Orient(apex, right, q) > kFlat && Orient(left, apex, q) > kFlat;
    };
    return inside(points_[previous_[p]]) || inside(points_[next_[p]]);
  }

  // Called where no corner is an ear: the rest crosses itself or is flat. Clipping a flat corner
  // does the least harm, then a convex one.
  uint32_t LeastBadCorner(uint32_t start) const {
    uint32_t best = start;
    double best_cost = INFINITY;
    uint32_t i = start;
    do {
      const double area = Area(i);
      const double reflex_penalty = area < -kFlat ? 8.0 : 0.0;  // above any area of the unit box
      if (std::abs(area) + reflex_penalty < best_cost) {
        best_cost = std::abs(area) + reflex_penalty;
        best = i;
      }
      i = next_[i];
    } while (i != start);
    return best;
  }

  void Clip(uint32_t i) {
    const uint32_t before = previous_[i], after = next_[i];
    triangles_.push_back({before, i, after});
    if (blocking_[i]) grid_.Remove(i);
    next_[before] = after;
    previous_[after] = before;
    UpdateBlocking(before);
    UpdateBlocking(after);
  }

  void UpdateBlocking(uint32_t i) {
    const bool blocking = Area(i) <= kFlat;
    if (blocking == static_cast<bool>(blocking_[i])) return;
    blocking_[i] = blocking;
    blocking ? grid_.Add(i) : grid_.Remove(i);
  }

  const std::vector<Point>& points_;
  CornerGrid grid_;
  std::vector<uint32_t> previous_, next_;
  std::vector<uint8_t> blocking_;  // reflex or flat: cannot be an ear, may lie in one
  std::vector<std::array<uint32_t, 3>>& triangles_;
};

// Both diagonals of a convex quadrilateral divide it. Of a concave one, only the diagonal from the reflex corner does.
void TriangulateQuad(std::span<const Vec3d> p, std::vector<std::array<uint32_t, 3>>* triangles) {
  const Vec3d normal = NewellNormal(p);
  const auto smaller_part = [&](size_t a, size_t b, size_t c, size_t d) {
    return std::min(Dot(normal, Cross(p[b] - p[a], p[c] - p[a])),
                    Dot(normal, Cross(p[c] - p[a], p[d] - p[a])));
  };
  const double part02 = smaller_part(0, 1, 2, 3);
  const double part13 = smaller_part(1, 2, 3, 0);
  const bool both_divide = part02 > 0 && part13 > 0;
  const bool use02 = both_divide ? Norm(p[2] - p[0]) <= Norm(p[3] - p[1]) : part02 >= part13;
  if (use02) {
    *triangles = {{0, 1, 2}, {0, 2, 3}};
  } else {
    *triangles = {{0, 1, 3}, {1, 2, 3}};
  }
}

}  // namespace

Vec3d NewellNormal(std::span<const Vec3d> polygon) {
  Vec3d normal;
  for (size_t i = 2; i < polygon.size(); ++i) {
    normal += Cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  }
  return normal;
}

void TriangulatePolygon(std::span<const Vec3d> polygon,
                        std::vector<std::array<uint32_t, 3>>* triangles) {
  triangles->clear();
  if (polygon.size() < 3) return;
  if (polygon.size() == 3) {
    triangles->push_back({0, 1, 2});
    return;
  }
  if (polygon.size() == 4) return TriangulateQuad(polygon, triangles);
  const std::vector<Point> points = Project(polygon);
  triangles->reserve(polygon.size() - 2);
  EarClipper(points, triangles).Run();
}

}  // namespace latticed
