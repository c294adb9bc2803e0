// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A direction in 8 bytes: octahedral coordinates of 32 bits each. The error is at most 2^-29 rad.
//
//   n / |n|_1 = (s, t, 1 - |s| - |t|) on the upper half of the octahedron; the lower half is folded
//   out: (s, t) -> ((1 - |t|) sign s, (1 - |s|) sign t)
//
// Threads  plain data and pure functions, host and device
#ifndef LATTICED_CUDA_PLAN_PACKED_DIRECTION_H_
#define LATTICED_CUDA_PLAN_PACKED_DIRECTION_H_

#include <cmath>
#include <cstdint>

#include "core/base/host_device.h"
#include "core/base/vec.h"

namespace latticed::kernels {

struct PackedDirection {
  int32_t s, t;
};

namespace packed_direction {
inline constexpr double kOne = 2147483647;  // 2^31 - 1
LATTICED_HD inline double Fold(double at, double other) {
  return std::copysign(1 - std::abs(other), at);
}
}  // namespace packed_direction

// `unit` has length 1.
inline PackedDirection PackDirection(Vec3d unit) {
  using packed_direction::Fold, packed_direction::kOne;
  const double norm1 = std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z);
  double s = unit.x / norm1, t = unit.y / norm1;
  if (unit.z < 0) {
    const double folded = Fold(s, t);
    t = Fold(t, s), s = folded;
  }
  return {static_cast<int32_t>(std::lround(s * kOne)), static_cast<int32_t>(std::lround(t * kOne))};
}

LATTICED_HD inline Vec3d UnpackDirection(PackedDirection packed) {
  using packed_direction::Fold, packed_direction::kOne;
  double s = packed.s / kOne, t = packed.t / kOne;
  const double z = 1 - std::abs(s) - std::abs(t);
  if (z < 0) {
    const double folded = Fold(s, t);
    t = Fold(t, s), s = folded;
  }
  return (1 / std::sqrt(s * s + t * t + z * z)) * Vec3d{s, t, z};
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_PACKED_DIRECTION_H_
