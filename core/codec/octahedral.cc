// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/octahedral.h"

#include <cmath>
#include <cstdlib>
#include <limits>

namespace latticed {
namespace {

// Draco calls anything shorter (in the L1 norm) the zero vector and stores +x for it.
constexpr double kShortestNormal = 1e-6;

int32_t RoundHalfUp(double value) { return static_cast<int32_t>(std::floor(value + 0.5)); }

}  // namespace

OctahedralNormal QuantiseNormal(Vec3f n, int bits) {
  const int32_t top = OctahedralMax(bits), centre = top / 2;
  double x = double{n.x}, y = double{n.y}, z = double{n.z};
  const double sum = std::abs(x) + std::abs(y) + std::abs(z);
  if (sum > kShortestNormal && sum <= std::numeric_limits<double>::max()) {
    const double scale = 1.0 / sum;
    x *= scale, y *= scale, z *= scale;
  } else {  // also for NaN
    x = 1, y = 0, z = 0;
  }

  // An integer vector of L1 norm `centre`; z takes the rounding errors of x and y.
  const int32_t ix = RoundHalfUp(x * centre);
  int32_t iy = RoundHalfUp(y * centre);
  int32_t iz = centre - std::abs(ix) - std::abs(iy);
  if (iz < 0) {
    iy += iy > 0 ? iz : -iz;
    iz = 0;
  }
  if (z < 0) iz = -iz;

  if (ix >= 0) return CanonicaliseOctahedral({iy + centre, iz + centre}, bits);
  return CanonicaliseOctahedral({iy < 0 ? std::abs(iz) : top - std::abs(iz),  //
                                 iz < 0 ? std::abs(iy) : top - std::abs(iy)},
                                bits);
}

Vec3f DequantiseNormal(OctahedralNormal n, int bits) {
  const float scale = 2.0f / static_cast<float>(OctahedralMax(bits));
  float y = static_cast<float>(n.s) * scale - 1.0f;
  float z = static_cast<float>(n.t) * scale - 1.0f;
  const float x = 1.0f - std::abs(y) - std::abs(z);
  // Outside the diamond x is negative: fold y and z back over its nearest edge.
  const float fold = x < 0 ? -x : 0.0f;
  y += y < 0 ? fold : -fold;
  z += z < 0 ? fold : -fold;
  const float inverse_length = 1.0f / std::sqrt(x * x + y * y + z * z);  // L1 norm 1: never zero
  return {x * inverse_length, y * inverse_length, z * inverse_length};
}

}  // namespace latticed
