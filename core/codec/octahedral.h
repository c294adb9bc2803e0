// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Octahedral normals, exactly as Draco stores them: the definition that every backend rounds to.
//
//   n / |n|_1 is folded onto the square; s and t are integers in 0 … 2^bits - 2 (the centre value
//   is 2^(bits-1) - 1). Points on the square's rim name the same direction twice: Canonicalise
//   picks one.
//
// Threads  pure functions; QuantiseNormal on host and device
#ifndef LATTICED_CORE_CODEC_OCTAHEDRAL_H_
#define LATTICED_CORE_CODEC_OCTAHEDRAL_H_

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "core/base/host_device.h"
#include "core/base/vec.h"

namespace latticed {

struct OctahedralNormal {
  int32_t s = 0, t = 0;
  friend bool operator==(const OctahedralNormal&, const OctahedralNormal&) = default;
};

// Largest value of s and t.
LATTICED_HD constexpr int32_t OctahedralMax(int bits) { return (1 << bits) - 2; }

LATTICED_HD constexpr OctahedralNormal CanonicaliseOctahedral(OctahedralNormal n, int bits) {
  const int32_t top = OctahedralMax(bits), centre = top / 2;
  if ((n.s == 0 && n.t == 0) || (n.s == 0 && n.t == top) || (n.s == top && n.t == 0)) {
    return {top, top};
  }
  if (n.s == 0 && n.t > centre) return {n.s, centre - (n.t - centre)};
  if (n.s == top && n.t < centre) return {n.s, centre + (centre - n.t)};
  if (n.t == top && n.s < centre) return {centre + (centre - n.s), n.t};
  if (n.t == 0 && n.s > centre) return {centre - (n.s - centre), n.t};
  return n;
}

// `n` need not be unit; the zero vector maps to +x. 6 <= bits <= 16.
LATTICED_HD inline OctahedralNormal QuantiseNormal(Vec3f n, int bits) {
  // Draco calls anything shorter (in the L1 norm) the zero vector and stores +x for it.
  constexpr double kShortestNormal = 1e-6;
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
  const int32_t ix = static_cast<int32_t>(std::floor(x * centre + 0.5));
  int32_t iy = static_cast<int32_t>(std::floor(y * centre + 0.5));
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

// The unit vector at the centre of the cell.
[[nodiscard]] inline Vec3f DequantiseNormal(OctahedralNormal n, int bits) {
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

#endif  // LATTICED_CORE_CODEC_OCTAHEDRAL_H_
