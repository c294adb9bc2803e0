// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/quantisation_box.h"

#include <algorithm>
#include <cmath>

namespace latticed {
namespace {

// The part of a new box's range that the bounds may take; the rest is margin.
constexpr double kLargestUse = 0.75;
// The box may shrink when the bounds take less than this part of its range.
constexpr double kSmallestUse = 0.25;
// Origins are multiples of range / kOriginGrid.
constexpr double kOriginGrid = 64;

double LongestEdge(const Bounds& bounds) {
  const Vec3d e = bounds.extent();
  return std::max({e.x, e.y, e.z});
}

}  // namespace

bool QuantisationBox::Contains(const Bounds& bounds) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (bounds.min[axis] < origin[axis] || bounds.max[axis] > origin[axis] + range) return false;
  }
  return true;
}

QuantisationBox FitQuantisationBox(const Bounds& bounds, uint64_t id) {
  const double longest = LongestEdge(bounds);
  const Vec3d center = bounds.center();
  const double largest =
      std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z), longest});
  // A point, or bounds too small for double at this distance from the origin, still get a box.
  const double needed = std::max({longest / kLargestUse, largest * 0x1p-40, 0x1p-100});
  QuantisationBox box{.id = id, .range = std::exp2(std::ceil(std::log2(needed)))};
  if (box.range * kLargestUse < longest) box.range *= 2;
  const double grid = box.range / kOriginGrid;
  for (int axis = 0; axis < 3; ++axis) {
    box.origin[axis] = std::round((center[axis] - 0.5 * box.range) / grid) * grid;
  }
  return box;
}

std::optional<QuantisationBox> NextQuantisationBox(const QuantisationBox& current,
                                                   const Bounds& bounds, bool gesture_open) {
  const bool too_large = LongestEdge(bounds) < kSmallestUse * current.range;
  if (current.Contains(bounds) && (gesture_open || !too_large)) return std::nullopt;
  QuantisationBox next = FitQuantisationBox(bounds, current.id + 1);
  // A box that is no smaller would only cost a full update.
  if (current.Contains(bounds) && next.range >= current.range) return std::nullopt;
  return next;
}

}  // namespace latticed
