// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far a surface bends along an edge, in one byte, as proto/latticed/v1/patches.proto sends it.
//
//   byte b   E <= unit 2^(b/2), and b is the least such: the bound grows by at most sqrt(2)
//   255      nothing is known: E is not a number, infinite, or above unit 2^127
//   unit     2^-32 times the least power of two that is at least the diagonal D of the mesh at rest
//
// E is the largest second derivative along the edge in all of its patches. With byte 0 an edge is straight enough for any
// tolerance above 8e-11 D, far below what float32 positions can show. 2^95 D, the largest bound, is beyond any lattice.
//
// Below 2^-62 world units a bound in float32 may be too small, because its square vanishes (core/adaptive/
// curvature_slack.h). The byte of a bound therefore allows for 2^-62 more. Meshes of more than 1e-9 world units do
// not notice.
//
// Units    world
// Threads  pure functions
#ifndef LATTICED_CORE_PATCHES_EDGE_BOUND_H_
#define LATTICED_CORE_PATCHES_EDGE_BOUND_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/bounds.h"
#include "core/base/host_device.h"

namespace latticed {

inline constexpr uint8_t kUnknownEdgeBound = 255;
inline constexpr double kVanishedCurvature = 0x1p-62;

// A power of two from 2^-126, so that float32 can hold it.
[[nodiscard]] inline double CurvatureUnit(const Bounds& mesh_bounds) {
  int exponent = 0;
  const double fraction = std::frexp(mesh_bounds.diagonal(), &exponent);  // in [1/2, 1)
  if (fraction == 0.5) --exponent;
  return std::ldexp(1.0, std::max(exponent - 32, -126));
}

// largest_curvature >= 0, or not a number.
[[nodiscard]] LATTICED_HD inline uint8_t EdgeBoundByte(double largest_curvature, double unit) {
  constexpr double kRootOfHalf = 0.70710678118654746;  // rounded down
  const double units = (largest_curvature + kVanishedCurvature) / unit;
  if (units <= 1) return 0;
  if (!(units <= 0x1p127)) return kUnknownEdgeBound;
  int exponent = 0;
  const double fraction = std::frexp(units, &exponent);  // in [1/2, 1)
  const int above = fraction <= 0.5 ? 2 : fraction <= kRootOfHalf ? 1 : 0;
  return static_cast<uint8_t>(2 * exponent - above);
}

// The bound that a byte stands for; infinite for kUnknownEdgeBound.
[[nodiscard]] inline double EdgeBound(uint8_t byte, double unit) {
  constexpr double kRootOf2 = 1.4142135623730951;  // rounded up
  if (byte == kUnknownEdgeBound) return std::numeric_limits<double>::infinity();
  return std::ldexp(byte % 2 == 0 ? unit : unit * kRootOf2, byte / 2);
}

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_EDGE_BOUND_H_
