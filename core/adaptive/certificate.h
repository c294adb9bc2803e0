// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far the triangles of a pattern can be from the exact patch.
//
// Lemma 1. f maps a triangle to space, M_ij >= sup |d^2 f along side ij|, and Lf is the linear interpolant of f at the
// corners. Then |f - Lf| <= (b0 b1 M_01 + b1 b2 M_12 + b2 b0 M_20) / 2 at barycentrics b.
//   Proof. For a unit vector e, let g = e (f - Lf) - the right side. Along side ij the second derivative of the right
//   side is -M_ij, so g is convex along all three directions. Its maximum is at a corner: from any other point one can
//   move along a side's direction, not down, until the rim, and there to a corner. At corners g = 0.
//
// LinearError is the largest right side. If M_ij are squares of the sides of an acute triangle, it is R^2 / 2 at the
// centre of the circumcircle, R the radius: sum b_i b_j M_ij = R^2 - |p - centre|^2. Otherwise one M is at least the
// sum of the other two, and the largest value is M / 8, at the middle of its side: it grows with the other two, and
// where they add up to M the triangle has a right angle and R^2 = M / 4. In all cases it is at most max M / 6, the
// value for three equal M.
//
// Lemma 2. A side of a triangle inside the patch whose ends differ by barycentrics d has M(d) at most
//
//   |d_0 d_1| M_01 + |d_1 d_2| M_12 + |d_2 d_0| M_20,   and for each corner i, with j and k the others,
//   d_j^2 M_ij + d_k^2 M_ik + 2 |d_j d_k| X_i,          X_i >= sup |d^2 f along ij and ik|
//
//   Proof. d = d_j e_ij + d_k e_ik since d_i = -d_j - d_k. So the second derivative along d is d_j^2 D_ij + d_k^2 D_ik
//   + 2 d_j d_k D_i. It is also -sum d_a d_b D_ab. The triangle inequality gives both.
//
// Points of patch and triangles are compared at equal barycentrics. The bound therefore holds both ways.
//
// In float32, LinearError of SideCurvature can be 2e-6 of itself too small. Multiply it by kBoundFactor.
//
// Units    world
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_CERTIFICATE_H_
#define LATTICED_CORE_ADAPTIVE_CERTIFICATE_H_

#include <array>
#include <cstdint>

#include "core/adaptive/adaptive_pattern.h"
#include "core/adaptive/patch_curvature.h"
#include "core/base/host_device.h"

namespace latticed {

// Lemma 1, for M of the three sides in any order.
template <typename T>
LATTICED_HD constexpr T LinearError(T a, T b, T c) {
  T largest = a, second = b, third = c;
  if (second > largest) {
    largest = b;
    second = a;
  }
  if (third > largest) {
    const T old = largest;
    largest = third;
    third = old;
  }
  if (!(second + third > largest)) return largest / 8;
  // R^2 / 2 for squared sides 1, u, v; the divisor is 16 times the squared area, and positive since u, v <= 1 < u + v.
  const T u = second / largest, v = third / largest, excess = u + v - 1;
  return largest * (u * v / (2 * (4 * u * v - excess * excess)));
}

// Lemma 2. `side` is |d|.
template <typename T>
LATTICED_HD constexpr T SideCurvature(const T* side, const CurvatureBounds<T>& m) {
  T least = 0;
  for (int e = 0; e < 3; ++e) least += side[e] * side[(e + 1) % 3] * m.edge[e];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    // Edge i joins corners i and j, edge k joins corners k and i.
    const T through = side[j] * side[j] * m.edge[i] + side[k] * side[k] * m.edge[k] +
                      2 * side[j] * side[k] * m.mixed[i];
    if (through < least) least = through;
  }
  return least;
}

// The largest distance between the exact patch and the triangles of a pattern, both ways.
[[nodiscard]] double PatternError(const AdaptivePattern& pattern, const CurvatureBounds<double>& m);

struct PatternChoice {
  const AdaptivePattern& pattern;
  double error;  // PatternError
};
// The sparser pattern of these levels if it has fewer points and its PatternError is at most `tolerance`. Else the denser
// one.
[[nodiscard]] PatternChoice ChoosePattern(const std::array<uint8_t, 3>& levels,
                                          const CurvatureBounds<double>& m, double tolerance);

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_CERTIFICATE_H_
