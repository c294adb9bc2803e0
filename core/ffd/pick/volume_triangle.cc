// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/pick/volume_triangle.h"

#include <cmath>

#include "core/ffd/box/bezier_box.h"
#include "core/ffd/direct_ffd.h"

namespace latticed {

void VolumeTriangle::Bound(Bounds& hull, std::array<Vec3d, 2>& slope,
                           std::array<Vec3d, 2>& spread) const {
  Bounds bounds;
  for (const Vec3d p : corners) bounds.Extend(p);
  const BezierBox box = RestrictVolume(structure, control_points, span, bounds.min, bounds.max);
  const Bounds own = box.Hull();
  hull = {hull.min + own.min, hull.max + own.max};
  for (int axis = 0; axis < 3; ++axis) {
    const double width = bounds.extent()[axis];
    if (!(width > 0)) continue;
    const Bounds slopes = box.SlopeHull(static_cast<size_t>(axis));
    for (size_t e = 0; e < 2; ++e) {
      const double share = (corners[e + 1][axis] - corners[0][axis]) / width;
      slope[e] += share * slopes.center();
      spread[e] += 0.5 * std::abs(share) * slopes.extent();
    }
  }
}

void VolumeTriangle::Add(double s, double t, Vec3d& position, std::array<Vec3d, 2>& slope) const {
  const std::array<Vec3d, 2> edges{corners[1] - corners[0], corners[2] - corners[0]};
  const VolumePoint point =
      EvaluateVolume(structure, control_points, span, corners[0] + s * edges[0] + t * edges[1]);
  position += point.position;
  for (size_t e = 0; e < 2; ++e) {
    for (int axis = 0; axis < 3; ++axis) slope[e] += edges[e][axis] * point.derivatives[axis];
  }
}

}  // namespace latticed
