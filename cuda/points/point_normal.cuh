// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The normal that a deformation carries, as a function of its Jacobian, and its derivatives. Formulas and twin:
// core/points/normal_kernel.h.
//
// Layout   Jacobians are three columns d(deformed)/d(x, y, z)
// Threads  device functions
#ifndef LATTICED_CUDA_POINTS_POINT_NORMAL_CUH_
#define LATTICED_CUDA_POINTS_POINT_NORMAL_CUH_

#include <array>
#include <cmath>

#include "core/base/vec.h"
#include "core/ffd/carried_normal.h"

namespace latticed::kernels {

class PointNormal {
 public:
  // `rest` is of unit length or zero.
  __device__ PointNormal(const std::array<Vec3d, 3>& jacobian, Vec3d rest)
      : j_(jacobian), rest_(rest) {
    const auto& [a, b, c] = j_;
    const Vec3d x = Cross(b, c), y = Cross(c, a), z = Cross(a, b);
    const Vec3d carried = rest.x * x + rest.y * y + rest.z * z;
    // The rules of CarryNormal, squared: this saves most of its roots and quotients.
    const double cofactor2 = Dot(x, x) + Dot(y, y) + Dot(z, z);
    const double length2 = Dot(carried, carried);
    const double rank_limit = kRankTolerance * (Dot(a, a) + Dot(b, b) + Dot(c, c));
    if (!(cofactor2 <= kMaxNormalCondition * kMaxNormalCondition * length2)) return;
    if (!(length2 > 0 && cofactor2 > rank_limit * rank_limit)) return;
    inverse_length_ = 1 / std::sqrt(length2);
    normal_ = inverse_length_ * carried;
  }

  __device__ Vec3d value() const { return normal_; }
  // How the normal moves when the Jacobian moves by `rate`.
  [[nodiscard]] __device__ Vec3d Velocity(const std::array<Vec3d, 3>& rate) const {
    const auto& [a, b, c] = j_;
    const auto& [da, db, dc] = rate;
    return Along(rest_.x * (Cross(db, c) + Cross(b, dc)) + rest_.y * (Cross(dc, a) + Cross(c, da)) +
                 rest_.z * (Cross(da, b) + Cross(a, db)));
  }
  // The cotangent of the Jacobian, by columns, for one of the normal.
  [[nodiscard]] __device__ std::array<Vec3d, 3> Cotangent(Vec3d g) const {
    const auto& [a, b, c] = j_;
    const Vec3d h = Along(g);
    return {rest_.y * Cross(h, c) + rest_.z * Cross(b, h),
            rest_.x * Cross(c, h) + rest_.z * Cross(h, a),
            rest_.x * Cross(h, b) + rest_.y * Cross(a, h)};
  }

 private:
  // What of v changes the direction; zero where the normal is undefined. This map is its own transpose.
  __device__ Vec3d Along(Vec3d v) const {
    return inverse_length_ * (v - Dot(normal_, v) * normal_);
  }

  const std::array<Vec3d, 3> j_;
  const Vec3d rest_;
  Vec3d normal_;
  double inverse_length_ = 0;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_POINTS_POINT_NORMAL_CUH_
