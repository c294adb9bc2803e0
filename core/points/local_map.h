// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The local coordinates of a knot box as a function of points of the world.
//
//   (l, m, n) = scale (x - frame origin) + offset,   each in [-1/2, 1/2] inside the box
//
// Units    world units; l, m, n without unit
// Threads  plain data, of host and device
#ifndef LATTICED_CORE_POINTS_LOCAL_MAP_H_
#define LATTICED_CORE_POINTS_LOCAL_MAP_H_

#include <array>

#include "core/base/vec.h"

namespace latticed {

// Number a is scale[a] . (x - frame_origin) + offset[a]. The rows `scale` are also d(l, m, n)/dx.
struct LocalMap {
  Vec3d frame_origin;
  std::array<Vec3d, 3> scale;
  Vec3d offset;
};

// (l, m, n) = (x, y, z).
inline constexpr LocalMap kWorldMap{
    .frame_origin = {}, .scale = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}, .offset = {}};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_LOCAL_MAP_H_
