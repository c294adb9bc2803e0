// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/trimming/parameter_rectangle.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace latticed::bench {
namespace {

struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void Extend(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  double length() const { return high - low; }
  double Part(double x) const { return length() > 0 ? (x - low) / length() : 0; }
};

// How far the corners extend along two unit vectors, measured from the first corner.
struct Extents {
  Vec3d x_axis, y_axis;
  Interval x, y;

  double area() const { return x.length() * y.length(); }
  double perimeter() const { return 2 * (x.length() + y.length()); }
};

// Prefers the smaller area, then the smaller perimeter: but for rounding, the three rectangles of
// an acute triangle have the same area.
bool IsBetter(const Extents& a, const Extents& b) {
  constexpr double kSame = 1e-9;
  if (a.area() < (1 - kSame) * b.area()) return true;
  return a.area() <= (1 + kSame) * b.area() && a.perimeter() < b.perimeter();
}

Extents ExtentsAlong(std::span<const Vec3d> corners, Vec3d x_axis, Vec3d normal) {
  Extents extents{.x_axis = x_axis, .y_axis = Cross(normal, x_axis), .x = {}, .y = {}};
  for (const Vec3d& corner : corners) {
    extents.x.Extend(Dot(corner - corners[0], extents.x_axis));
    extents.y.Extend(Dot(corner - corners[0], extents.y_axis));
  }
  return extents;
}

}  // namespace

ParameterRectangle SmallestRectangle(std::span<const Vec3d> corners, Vec3d normal) {
  std::optional<Extents> best;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3d side = corners[(i + 1) % corners.size()] - corners[i];
    const double length = Norm(side);
    if (length == 0) continue;
    const Extents extents = ExtentsAlong(corners, side / length, normal);
    if (!best || IsBetter(extents, *best)) best = extents;
  }
  if (!best) best = ExtentsAlong(corners, {1, 0, 0}, normal);  // all corners coincide
  ParameterRectangle result{
      .corner = corners[0] + best->x.low * best->x_axis + best->y.low * best->y_axis,
      .along = best->x.length() * best->x_axis,
      .across = best->y.length() * best->y_axis,
      .polygon = {}};
  for (const Vec3d& corner : corners) {
    const Vec3d from_first = corner - corners[0];
    result.polygon.push_back(
        {best->x.Part(Dot(from_first, best->x_axis)), best->y.Part(Dot(from_first, best->y_axis))});
  }
  return result;
}

}  // namespace latticed::bench
