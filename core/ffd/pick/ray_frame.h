// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The ray as the z axis of a right-handed frame. The origin is the point of the ray's line nearest to `near`, so that
// coordinates keep their digits however far away the ray begins.
//
// Threads  immutable
#ifndef LATTICED_CORE_FFD_PICK_RAY_FRAME_H_
#define LATTICED_CORE_FFD_PICK_RAY_FRAME_H_

#include <array>
#include <cmath>

#include "core/base/vec.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/pick/surface_pick.h"

namespace latticed {

class RayFrame {
 public:
  RayFrame(const Ray& ray, Vec3d near) {
    const Vec3d z = Unit(ray.direction);
    int least = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (std::abs(z[axis]) < std::abs(z[least])) least = axis;
    }
    Vec3d other;
    other[least] = 1;
    const Vec3d x = Unit(Cross(z, other));
    axes_ = {x, Cross(z, x), z};
    begin_ = Dot(ray.origin - near, z);
    origin_ = ray.origin - begin_ * z;
  }

  Vec3d ToRay(Vec3d world) const { return Turn(world - origin_); }
  // The same for a difference of points.
  Vec3d Turn(Vec3d d) const { return {Dot(d, axes_[0]), Dot(d, axes_[1]), Dot(d, axes_[2])}; }
  // z of the point where the ray begins.
  double begin() const { return begin_; }

 private:
  std::array<Vec3d, 3> axes_;
  Vec3d origin_;
  double begin_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PICK_RAY_FRAME_H_
