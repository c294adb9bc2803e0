// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One component of a box polynomial along a straight edge, as a polynomial in tau. The positions do not
// depend on which of the edge's two patches asks.
//
//   l(tau) = midpoint + tau direction,  tau in [-1/2, 1/2]
//
// Exchanging the edge's ends changes the sign of the direction, and exactly that of every odd coefficient.
// So both patches of an edge get the same bits, whichever way each runs along it.
#ifndef LATTICED_CUDA_FUSED_FUSED_EDGE_CUH_
#define LATTICED_CUDA_FUSED_FUSED_EDGE_CUH_

#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

// out (degree N + 1) = p (degree N) * (m + d tau) + r (degree R).
template <int N, int R>
__device__ __forceinline__ void MultiplyLinearAdd1(const float* p, float m, float d, const float* r,
                                                   float* out) {
#pragma unroll
  for (int k = 0; k <= N + 1; ++k) {
    float sum = k <= R ? r[k] : 0.0f;
    if (k <= N) sum = fmaf(p[k], m, sum);
    if (k > 0) sum = fmaf(p[k - 1], d, sum);
    out[k] = sum;
  }
}

template <int D0, int D1, int D2>
class EdgeComposition {
 public:
  // out: coefficients of tau^0 … tau^(D0 + D1 + D2).
  __device__ static __forceinline__ void Compose(const float* c, const float* midpoint,
                                                 const float* direction, float* out) {
    Outer<0>(c, midpoint, direction, out);
  }

 private:
  template <int C>
  __device__ static __forceinline__ void Inner(const float* c, const float* m, const float* d,
                                               float* out) {
    if constexpr (C == D2) {
      out[0] = c[C];
    } else {
      float p[D2 - C];
      Inner<C + 1>(c, m, d, p);
      MultiplyLinearAdd1<D2 - C - 1, 0>(p, m[2], d[2], c + C, out);
    }
  }

  template <int B>
  __device__ static __forceinline__ void Middle(const float* c, const float* m, const float* d,
                                                float* out) {
    const float* row = c + B * (D2 + 1);
    if constexpr (B == D1) {
      Inner<0>(row, m, d, out);
    } else {
      constexpr int kN = D2 + D1 - B - 1;
      float p[kN + 1], r[D2 + 1];
      Middle<B + 1>(c, m, d, p);
      Inner<0>(row, m, d, r);
      MultiplyLinearAdd1<kN, D2>(p, m[1], d[1], r, out);
    }
  }

  template <int A>
  __device__ static __forceinline__ void Outer(const float* c, const float* m, const float* d,
                                               float* out) {
    const float* plane = c + A * (D1 + 1) * (D2 + 1);
    if constexpr (A == D0) {
      Middle<0>(plane, m, d, out);
    } else {
      constexpr int kN = D2 + D1 + D0 - A - 1;
      float p[kN + 1], r[D1 + D2 + 1];
      Outer<A + 1>(c, m, d, p);
      Middle<0>(plane, m, d, r);
      MultiplyLinearAdd1<kN, D1 + D2>(p, m[0], d[0], r, out);
    }
  }
};

// The even and the odd part of a polynomial of degree N in tau: p(±tau) = even ± tau odd.
template <int N>
__device__ __forceinline__ void SplitPowers(const float* p, float tau2, float& even, float& odd) {
  constexpr int kEven = N - N % 2, kOdd = N - 1 + N % 2;
  even = p[kEven];
  odd = p[kOdd];
#pragma unroll
  for (int k = kEven - 2; k >= 0; k -= 2) even = fmaf(even, tau2, p[k]);
#pragma unroll
  for (int k = kOdd - 2; k >= 1; k -= 2) odd = fmaf(odd, tau2, p[k]);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_EDGE_CUH_
