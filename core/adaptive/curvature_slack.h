// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What rounding to float32 can take from the bounds of core/adaptive/patch_curvature-inl.h.
//
//   exact bound <= (1 + 2e-6) (computed bound + sum_ab v_a v_b slack_ab)
//   slack_ab = (13 n + 8) 2^-24 S_ab      v = 2 |along| + |across|, by component, in box-local coordinates
//
// along and across are the steps of x and t. S_ab bounds the second derivatives of the box polynomial R = sum C_k l^k
// as if all terms had one sign: S_ab = sum_k |C_k| d^2 l^k / dl_a dl_b at l = reach. For each patch of the box,
// reach_a >= |centre_a| + |along_a| / 2 + |across_a| / 2. Terms of degree 0 and 1 do not reach a second derivative,
// and with weights only those of degree 0.
//
// Derivation. A computed Bernstein coefficient of a second derivative is a sum of products, each of one C_k, factors of
// the patch's map, and constants. Were all signs equal, the sum would be at most sum_ab v_a v_b S_ab: the polar form is
// taken at points with |x|, |t| <= 1/2, and its directions are at most |across| + 2 |along| (edge 12 is formed as
// e02 - e01). A product is rounded at most so many times, where a multiply-add that is not fused counts 2:
//
//   inputs        1 of C_k, n of the factors of the map                                   n + 1
//   composition   by Horner's rule: 3 multiply-adds for each of n factors                 6 n
//   polar form    the weight, the product                                                 2
//   butterflies   two, of m/2 + 1 multiply-adds and an addition                           2 m + 6
//   T -> V2       m multiply-adds; m factors 2s - 1, each wrong by 2^-23 at most          4 m
//   edges         4 operations of 2 roundings, and the factor s twice                     10
//
// With m = n - 2 the sum is 13 n + 7: 46 at n = 3, 85 at n = 6, 124 at n = 9. Each rounding is a factor 1 + e with
// |e| <= 2^-24; one more in the sum stands for their products. The norm, its root and the slack itself round at most
// 30 times, for which 2e-6 stands.
//
// With vertex weights a patch is x + w (R - x): its second derivatives are those of w G, G = R - x of the coefficients C_k
// now, w = w_0 + w_x x + w_t t. That is one more affine factor, so n + 1 stands for n, and
//
//   slack = (13 (n + 1) + 8) 2^-24 (W sum_ab v_a v_b S_ab + 2 V sum_a v_a S_a)
//   W = |w_0| + |w_x| / 2 + |w_t| / 2      V = 2 |w_x| + |w_t|      S_a as S_ab, with one derivative
//
// Limits   bounds below 1e-19 world units may vanish: their squares are not normal floats
// Units    slack_ab in world units
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_CURVATURE_SLACK_H_
#define LATTICED_CORE_ADAPTIVE_CURVATURE_SLACK_H_

#include <array>
#include <span>

#include "core/adaptive/patch_curvature.h"
#include "core/base/host_device.h"
#include "core/base/vec.h"

namespace latticed {

inline constexpr double kBoundFactor = 1 + 2e-6;

// slack_00, slack_11, slack_22, 2 slack_01, 2 slack_12, 2 slack_20 of a box. `degree` and the order of the coefficients
// are those of BoxBasis::Polynomial.
[[nodiscard]] std::array<double, 6> CurvatureSlack(std::span<const Vec3d> coefficients,
                                                   const std::array<int, 3>& degree, Vec3d reach);

// What a patch needs of its box's reach.
[[nodiscard]] inline Vec3d PatchReach(Vec3d centre, Vec3d along, Vec3d across) {
  Vec3d reach;
  for (int a = 0; a < 3; ++a) {
    reach[a] = std::abs(centre[a]) + 0.5 * std::abs(along[a]) + 0.5 * std::abs(across[a]);
  }
  return reach;
}

// sum_ab v_a v_b slack_ab. Six multiply-adds and six multiplications.
template <typename T>
LATTICED_HD inline T PatchSlack(const T* v, const T* slack) {
  return v[0] * (v[0] * slack[0] + v[1] * slack[3]) + v[1] * (v[1] * slack[1] + v[2] * slack[4]) +
         v[2] * (v[2] * slack[2] + v[0] * slack[5]);
}

// The same with vertex weights. slack[6 + a] = 2 S_a (13 (n + 1) + 8) 2^-24, and n + 1 stands for n in the others.
template <typename T>
LATTICED_HD inline T WeightedPatchSlack(const T* v, const T* w, const T* slack) {
  const T w_x = std::abs(w[1]), w_t = std::abs(w[2]);
  const T most = std::abs(w[0]) + static_cast<T>(0.5) * (w_x + w_t);
  const T first = v[0] * slack[6] + v[1] * slack[7] + v[2] * slack[8];
  return most * PatchSlack(v, slack) + (2 * w_x + w_t) * first;
}

template <typename T>
LATTICED_HD inline void RaiseBounds(T patch_slack, CurvatureBounds<T>* bounds) {
  for (int e = 0; e < 3; ++e) {
    bounds->edge[e] = static_cast<T>(kBoundFactor) * (bounds->edge[e] + patch_slack);
    bounds->mixed[e] = static_cast<T>(kBoundFactor) * (bounds->mixed[e] + patch_slack);
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_CURVATURE_SLACK_H_
