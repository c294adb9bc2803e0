// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates one component of a patch: from its Taylor coefficients P_ij = d^i/dx^i d^j/dt^j, ordered by
// At(i, j), to those of a row, and to the row's points:
//
//   row t       p_i = sum_j P_ij t^j / j!
//   point x     p(x) = sum_i p_i x^i / i!
//
// The even and the odd part are computed once for t and -t, and once for x and -x.
#ifndef LATTICED_CUDA_FUSED_FUSED_ROW_POLYNOMIAL_CUH_
#define LATTICED_CUDA_FUSED_FUSED_ROW_POLYNOMIAL_CUH_

#include "cuda/fused/fused_polynomial.cuh"

namespace latticed::kernels {

// t^j / j! for even j, t^(j - 1) / j! for odd.
template <int N>
struct RowPowers {
  float t, of[size_t{N} + 1];

  __device__ explicit RowPowers(float t) : t(t) {
    constexpr float kInverse[11] = {
        1,          1,           1.0f / 2,     1.0f / 6,      1.0f / 24,     1.0f / 120,
        1.0f / 720, 1.0f / 5040, 1.0f / 40320, 1.0f / 362880, 1.0f / 3628800};
    float even = 1;
#pragma unroll
    for (int j = 0; j <= N; ++j) {
      if (j > 0 && j % 2 == 0) even *= t * t;
      of[j] = even * kInverse[j];
    }
  }
};

// Coefficients of the rows t (plus) and -t (minus): even ± t odd.
template <int N, int kMost>
__device__ __forceinline__ void CollapseRows(const float* p, const RowPowers<kMost>& powers,
                                             float* plus, float* minus) {
#pragma unroll
  for (int i = 0; i <= N; ++i) {
    float even = p[At(i, 0)];
    if (i == N) {
      plus[i] = minus[i] = even;
      continue;
    }
    float odd = p[At(i, 1)];
#pragma unroll
    for (int j = 2; j <= N - i; ++j) {
      float& part = j % 2 == 0 ? even : odd;
      part = fmaf(p[At(i, j)], powers.of[j], part);
    }
    plus[i] = fmaf(odd, powers.t, even);
    minus[i] = fmaf(-odd, powers.t, even);
  }
}

// Factors for the point x of a row: by[i] = x^2 / (i (i + 1)). They are computed and not loaded: rows
// already wait for their loads from shared memory.
template <int N>
struct RowStep {
  float x, by[size_t{N}];

  __device__ __forceinline__ explicit RowStep(float x) : x(x) {
#pragma unroll
    for (int i = 1; i < N; ++i) by[i] = x * x * (1.0f / static_cast<float>(i * (i + 1)));
  }
};

// p(±x) = even ± x odd for Taylor coefficients of degree N.
template <int N, int kMost>
__device__ __forceinline__ void SplitRow(const float* p, const RowStep<kMost>& step, float& even,
                                         float& odd) {
  constexpr int kEven = N - N % 2, kOdd = N - 1 + N % 2;
  even = p[kEven];
  odd = p[kOdd];
#pragma unroll
  for (int i = kEven - 2; i >= 0; i -= 2) even = fmaf(even, step.by[i + 1], p[i]);
#pragma unroll
  for (int i = kOdd - 2; i >= 1; i -= 2) odd = fmaf(odd, step.by[i + 1], p[i]);
}

// Values at x and -x.
template <int N, int kMost>
__device__ __forceinline__ void AtBoth(const float* p, const RowStep<kMost>& step, float& at_x,
                                       float& at_minus_x) {
  float even, odd;
  SplitRow<N>(p, step, even, odd);
  at_x = fmaf(odd, step.x, even);
  at_minus_x = fmaf(-odd, step.x, even);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_ROW_POLYNOMIAL_CUH_
