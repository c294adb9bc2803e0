// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How the deformation maps a normal, in double.
//
//   n' = cof(J) n / |…|       kappa = ||cof J||_F |n| / |cof(J) n|, the condition of n'
//
// kappa is infinite where J has rank 1 or 0 to 12 digits. A normal with kappa above kMaxNormalCondition is replaced by
// the one at the patch's centroid, or by the rest normal if kappa is too large there as well. Normals are therefore
// always unit and finite.
//
// Layout   Jacobians are three columns d(deformed)/d(x, y, z)
// Errors   none
// Threads  pure functions, host and device
#ifndef LATTICED_CORE_FFD_CARRIED_NORMAL_H_
#define LATTICED_CORE_FFD_CARRIED_NORMAL_H_

#include <cmath>
#include <limits>

#include "core/base/host_device.h"
#include "core/base/vec.h"

namespace latticed {

inline constexpr double kMaxNormalCondition = 1e4;
// A cofactor below this fraction of |J|^2 is a rounding error: J then maps space to a line, and kappa means nothing.
inline constexpr double kRankTolerance = 1e-12;

// Unit vector along v, or zero where v has no direction.
LATTICED_HD inline Vec3d Unit(Vec3d v) {
  // Scales v first, because the squares of a tiny patch's normal would underflow.
  const double x = std::abs(v.x), y = std::abs(v.y), z = std::abs(v.z);
  const double xy = x < y ? y : x, largest = xy < z ? z : xy;
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  const Vec3d scaled = v / largest;
  return scaled / Norm(scaled);
}

// cof(J) n: the deformed normal, not normalised.
LATTICED_HD inline Vec3d ApplyCofactor(const Vec3d* j, Vec3d n) {
  return n.x * Cross(j[1], j[2]) + n.y * Cross(j[2], j[0]) + n.z * Cross(j[0], j[1]);
}

// Frobenius norm of cof(J).
LATTICED_HD inline double CofactorNorm(const Vec3d* j) {
  const Vec3d a = Cross(j[1], j[2]), b = Cross(j[2], j[0]), c = Cross(j[0], j[1]);
  return std::sqrt(Dot(a, a) + Dot(b, b) + Dot(c, c));
}

struct CarriedNormal {
  Vec3d direction;  // unit where kappa is finite
  double kappa = std::numeric_limits<double>::infinity();
};

LATTICED_HD inline CarriedNormal CarryNormal(const Vec3d* jacobian, Vec3d rest_normal) {
  const Vec3d carried = ApplyCofactor(jacobian, rest_normal);
  const double length = Norm(carried);
  const double cofactor = CofactorNorm(jacobian);
  const double kappa = cofactor * Norm(rest_normal) / length;
  double size2 = 0;
  for (int column = 0; column < 3; ++column) size2 += Dot(jacobian[column], jacobian[column]);
  if (!(length > 0) || !std::isfinite(kappa) || !(cofactor > kRankTolerance * size2)) return {};
  return {Unit(carried), kappa};
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_CARRIED_NORMAL_H_
