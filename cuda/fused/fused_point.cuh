// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates one component of a box's polynomial R and of its Jacobian at one point, by Horner's rule. Twin
// of core/cpu/fused/kernel/fused_point-inl.h.
#ifndef LATTICED_CUDA_FUSED_FUSED_POINT_CUH_
#define LATTICED_CUDA_FUSED_FUSED_POINT_CUH_

#include "cuda/fused/fused_geometry.cuh"
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

// `c` as BoxPolynomials has it, l box-local coordinates. jet[0] = R, and with kSlopes
// jet[1 + i] = dR / dl_(2 - i). The bits of R do not depend on kSlopes.
template <int D0, int D1, int D2, bool kSlopes>
class PointJet {
 public:
  __device__ static __forceinline__ void Evaluate(const float* c, const float* l, float* jet) {
    constexpr int kEntries = kSlopes ? 3 : 1, kPlane = (D1 + 1) * (D2 + 1);
    Middle(c + D0 * kPlane, l, jet);
#pragma unroll
    for (int a = D0 - 1; a >= 0; --a) {
      float next[kEntries];
      Middle(c + a * kPlane, l, next);
      Step<kEntries>(l[0], next, a == D0 - 1, jet);
    }
  }

 private:
  // One step of Horner's rule, sum * l + next. `sum` holds the value and its derivatives by the inner
  // coordinates, kEntries in all; with kSlopes the derivative by l itself comes after them.
  template <int kEntries>
  __device__ static __forceinline__ void Step(float l, const float* next, bool first, float* sum) {
    if constexpr (kSlopes) sum[kEntries] = first ? sum[0] : fmaf(sum[kEntries], l, sum[0]);
#pragma unroll
    for (int i = 0; i < kEntries; ++i) sum[i] = fmaf(sum[i], l, next[i]);
  }

  __device__ static __forceinline__ void Inner(const float* row, const float* l, float* jet) {
    jet[0] = row[D2];
#pragma unroll
    for (int k = D2 - 1; k >= 0; --k) Step<1>(l[2], row + k, k == D2 - 1, jet);
  }

  __device__ static __forceinline__ void Middle(const float* plane, const float* l, float* jet) {
    constexpr int kEntries = kSlopes ? 2 : 1;
    Inner(plane + D1 * (D2 + 1), l, jet);
#pragma unroll
    for (int b = D1 - 1; b >= 0; --b) {
      float next[kEntries];
      Inner(plane + b * (D2 + 1), l, next);
      Step<kEntries>(l[1], next, b == D1 - 1, jet);
    }
  }
};

// cof(J) n = n0 J1 x J2 + n1 J2 x J0 + n2 J0 x J1, from the jets of R's three components.
__device__ __forceinline__ float3 CofactorTimes(const float (&jet)[3][4], const float (&n)[3]) {
  const float3 j0{jet[0][3], jet[1][3], jet[2][3]}, j1{jet[0][2], jet[1][2], jet[2][2]},
      j2{jet[0][1], jet[1][1], jet[2][1]};
  // n0 J1 x J2 + n1 J2 x J0 = (n0 J1 - n1 J0) x J2.
  const float3 side{fmaf(n[0], j1.x, -n[1] * j0.x), fmaf(n[0], j1.y, -n[1] * j0.y),
                    fmaf(n[0], j1.z, -n[1] * j0.z)};
  const float3 sum = CrossProduct(side, j2), last = CrossProduct(j0, j1);
  return {fmaf(n[2], last.x, sum.x), fmaf(n[2], last.y, sum.y), fmaf(n[2], last.z, sum.z)};
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_POINT_CUH_
