// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of the second derivatives of a patch, from its Bézier control net T of degree n >= 2.
//
//   d_e d_f P = n (n - 1) sum_{|a| = n - 2} D_e D_f T_a B_a     D_e T_a = T_{a + q} - T_{a + p},  edge e from corner p to q
//
// The norm of a second derivative is at most the largest norm of its coefficients. Edges and pairs of edges are those of
// CurvatureBounds.
//
// Layout   the order of bernstein.h
// Threads  pure functions, host and device
#ifndef LATTICED_CORE_ADAPTIVE_NET_CURVATURE_H_
#define LATTICED_CORE_ADAPTIVE_NET_CURVATURE_H_

#include <cmath>

#include "core/adaptive/patch_curvature.h"
#include "core/base/host_device.h"
#include "core/base/vec.h"
#include "core/ffd/box/bernstein.h"

namespace latticed {

// The squared norms of D_e D_f T_a of one index a = (i, j, n - 2 - i - j). `net`: T at a place of bernstein.h.
template <typename Net>
LATTICED_HD inline CurvatureBounds<double> SquaredDifferences(int n, int i, int j, const Net& net) {
  const int k = n - 2 - i - j;
  const auto at = [&](int c, int d) {  // T_{a + c + d}
    return net(BernsteinIndex(n, i + (c == 0) + (d == 0), k + (c == 2) + (d == 2)));
  };
  const Vec3d t00 = at(0, 0), t11 = at(1, 1), t22 = at(2, 2);
  const Vec3d t01 = at(0, 1), t12 = at(1, 2), t20 = at(2, 0);
  const auto squared = [](Vec3d v) { return Dot(v, v); };
  return {{squared(t00 - 2.0 * t01 + t11), squared(t11 - 2.0 * t12 + t22),
           squared(t22 - 2.0 * t20 + t00)},
          {squared(t12 - t01 - t20 + t00), squared(t20 - t12 - t01 + t11),
           squared(t01 - t20 - t12 + t22)}};
}

// The bounds, in double; not a number where an entry of the net is none or infinite.
template <typename Net>
[[nodiscard]] inline CurvatureBounds<double> BoundNet(int n, const Net& net) {
  CurvatureBounds<double> bounds;
  double check = 0;  // or not a number; a maximum would lose it
  for (int i = n - 2; i >= 0; --i) {
    for (int j = n - 2 - i; j >= 0; --j) {
      const CurvatureBounds<double> squared = SquaredDifferences(n, i, j, net);
      for (int e = 0; e < 3; ++e) {
        check += 0 * squared.edge[e] + 0 * squared.mixed[e];
        bounds.edge[e] = std::fmax(bounds.edge[e], squared.edge[e]);
        bounds.mixed[e] = std::fmax(bounds.mixed[e], squared.mixed[e]);
      }
    }
  }
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = n * (n - 1) * std::sqrt(bounds.edge[e]) + check;
    bounds.mixed[e] = n * (n - 1) * std::sqrt(bounds.mixed[e]) + check;
  }
  return bounds;
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_NET_CURVATURE_H_
