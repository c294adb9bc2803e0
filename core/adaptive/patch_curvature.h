// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bounds of core/adaptive/patch_curvature-inl.h for one patch in float or double, on the host and on CUDA.
//
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_PATCH_CURVATURE_H_
#define LATTICED_CORE_ADAPTIVE_PATCH_CURVATURE_H_

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/base/host_device.h"

namespace latticed {

#include "core/adaptive/patch_curvature-inl.h"

template <typename T>
struct ScalarOps {
  using V = T;
  LATTICED_HD static constexpr V Set(double value) { return static_cast<V>(value); }
  LATTICED_HD static constexpr V Add(V a, V b) { return a + b; }
  LATTICED_HD static constexpr V Sub(V a, V b) { return a - b; }
  LATTICED_HD static constexpr V Mul(V a, V b) { return a * b; }
  LATTICED_HD static constexpr V MulAdd(V a, V b, V c) { return a * b + c; }
  LATTICED_HD static constexpr V Max(V a, V b) { return a > b ? a : b; }
};

// Upper bounds of a patch's second derivatives, in world units.
template <typename T>
struct CurvatureBounds {
  T edge[3] = {};   // along edge e, from corner e to corner (e + 1) % 3
  T mixed[3] = {};  // along both edges that leave corner i
};

// The larger of two bounds, which are not negative; one that is not a number is larger than all others, as by their bits.
inline float LargerBound(float a, float b) {
  return std::bit_cast<uint32_t>(a) < std::bit_cast<uint32_t>(b) ? b : a;
}

// p[component][At(i, j)]; n = kDegree >= 2. Each bound is at least the exact one less the slack of
// core/adaptive/curvature_slack.h; RaiseBounds adds it.
template <int kDegree, typename T>
LATTICED_HD inline CurvatureBounds<T> BoundCurvature(const T* const* p, T shear) {
  CurvatureBounds<T> bounds;
  PatchCurvature<kDegree, ScalarOps<T>>::SquaredBounds(p, shear, bounds.edge, bounds.mixed);
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = std::sqrt(bounds.edge[e]);
    bounds.mixed[e] = std::sqrt(bounds.mixed[e]);
  }
  return bounds;
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_PATCH_CURVATURE_H_
