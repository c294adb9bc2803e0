// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/weights/weighted_triangle.h"

#include <algorithm>
#include <cmath>

namespace latticed {

void WeightedTriangle::Combine(double s, double t, Vec3d& position,
                               std::array<Vec3d, 2>& slope) const {
  const Vec3d offset = position;
  const double w = weight[0] + s * (weight[1] - weight[0]) + t * (weight[2] - weight[0]);
  position = rest[0] + s * (rest[1] - rest[0]) + t * (rest[2] - rest[0]) + w * offset;
  for (size_t e = 0; e < 2; ++e) {
    slope[e] = rest[e + 1] - rest[0] + w * slope[e] + (weight[e + 1] - weight[0]) * offset;
  }
}

Bounds WeightedTriangle::Hull(const Bounds& offset) const {
  Bounds hull;
  for (const Vec3d p : rest) hull.Extend(p);
  const auto [least, most] = std::ranges::minmax(weight);
  return WeightedHull(hull, offset, least, most);
}

void WeightedTriangle::BoundSlope(size_t e, const Bounds& offset, Vec3d& slope,
                                  Vec3d& spread) const {
  const auto [least, most] = std::ranges::minmax(weight);
  const double middle = 0.5 * (least + most), half = 0.5 * (most - least);
  const double rise = weight[e + 1] - weight[0];
  const Vec3d size{std::abs(slope.x), std::abs(slope.y), std::abs(slope.z)};
  spread = middle * spread + half * (size + spread) + 0.5 * std::abs(rise) * offset.extent();
  slope = rest[e + 1] - rest[0] + middle * slope + rise * offset.center();
}

Bounds WeightedHull(const Bounds& rest, const Bounds& offset, double least, double most) {
  Bounds hull;
  hull.Extend(rest.min + Min(least * offset.min, most * offset.min));
  hull.Extend(rest.max + Max(least * offset.max, most * offset.max));
  return hull;
}

}  // namespace latticed
