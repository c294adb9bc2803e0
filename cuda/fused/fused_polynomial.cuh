// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Composition of one component of a box polynomial with the affine map of a patch, exactly, in
// registers: one patch a lane.
//
// A bivariate polynomial of degree n is an array of (n+1)(n+2)/2 coefficients, that of x^i t^j at
// At(i, j). They are ordered by degree, so a polynomial of lower degree is a prefix. All loops have
// constant bounds and are unrolled.
// Twin of core/cpu/fused/kernel/fused_polynomial-inl.h.
#ifndef LATTICED_CUDA_FUSED_FUSED_POLYNOMIAL_CUH_
#define LATTICED_CUDA_FUSED_FUSED_POLYNOMIAL_CUH_

#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

LATTICED_HD constexpr int Terms(int degree) { return (degree + 1) * (degree + 2) / 2; }
LATTICED_HD constexpr int At(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// out (degree N + 1) = p (degree N) * (l[0] + l[1] x + l[2] t) + r (degree R <= N + 1).
template <int N, int R>
__device__ __forceinline__ void MultiplyLinearAdd(const float* p, const float* l, const float* r,
                                                  float* out) {
#pragma unroll
  for (int degree = 0; degree <= N + 1; ++degree) {
#pragma unroll
    for (int j = 0; j <= degree; ++j) {
      const int i = degree - j;
      float sum = degree <= R ? r[At(i, j)] : 0.0f;
      if (degree <= N) sum = fmaf(p[At(i, j)], l[0], sum);
      if (i > 0) sum = fmaf(p[At(i - 1, j)], l[1], sum);
      if (j > 0) sum = fmaf(p[At(i, j - 1)], l[2], sum);
      out[At(i, j)] = sum;
    }
  }
}

// Box-local coordinates l_0, l_1, l_2 of the patch's point (x, t), and powers of the last.
template <int D2>
struct AffineMap {
  float l[3][3];    // [axis][1, x, t]
  float square[6];  // l_2^2
  float cube[10];   // l_2^3
  float normal[3];  // direction of the facet normal; smooth normals only

  __device__ __forceinline__ void FormPowers() {
    const float zero[1] = {0.0f};
    if constexpr (D2 >= 2) MultiplyLinearAdd<1, 0>(l[2], l[2], zero, square);
    if constexpr (D2 >= 3) MultiplyLinearAdd<2, 0>(square, l[2], zero, cube);
  }
};

// One component's polynomial of degrees D0, D1, D2 in l_0, l_1, l_2, composed with a map; with
// kDerivative also its derivative along map.normal.
template <int D0, int D1, int D2, bool kDerivative>
class Composition {
 public:
  static constexpr int kDegree = D0 + D1 + D2;
  // `c` as BoxPolynomials has it. out: Terms(kDegree), d_out: Terms(kDegree - 1).
  __device__ static __forceinline__ void Compose(const float* c, const AffineMap<D2>& map,
                                                 float* out, float* d_out) {
    Outer<0>(c, map, out, d_out);
  }

 private:
  // sum_k c[k] l2^k: degree D2.
  __device__ static __forceinline__ void Inner(const float* c, const AffineMap<D2>& map,
                                               float* out) {
#pragma unroll
    for (int k = 0; k < Terms(D2); ++k) {
      float sum = k == 0 ? c[0] : 0.0f;
      if (k < Terms(1)) sum = fmaf(c[1], map.l[2][k], sum);
      if (D2 >= 2 && k < Terms(2)) sum = fmaf(c[2], map.square[k], sum);
      if (D2 >= 3) sum = fmaf(c[3], map.cube[k], sum);
      out[k] = sum;
    }
  }

  // Its derivative along the normal: degree D2 - 1.
  __device__ static __forceinline__ void InnerDerivative(const float* c, const AffineMap<D2>& map,
                                                         float* out) {
    const float by_normal = map.normal[2];
    const float c1 = c[1] * by_normal, c2 = D2 >= 2 ? 2 * c[2] * by_normal : 0.0f,
                c3 = D2 >= 3 ? 3 * c[3] * by_normal : 0.0f;
#pragma unroll
    for (int k = 0; k < Terms(D2 - 1); ++k) {
      float sum = k == 0 ? c1 : 0.0f;
      if (D2 >= 2 && k < Terms(1)) sum = fmaf(c2, map.l[2][k], sum);
      if (D2 >= 3) sum = fmaf(c3, map.square[k], sum);
      out[k] = sum;
    }
  }

  // out = p l + r, and d_out = (p l + r)' = d_p l + p normal + d_r.
  template <int N, int R>
  __device__ static __forceinline__ void Step(const float* p, const float* d_p, const float* l,
                                              float normal, const float* r, const float* d_r,
                                              float* out, float* d_out) {
    MultiplyLinearAdd<N, R>(p, l, r, out);
    if constexpr (kDerivative) {
      MultiplyLinearAdd<N - 1, R - 1>(d_p, l, d_r, d_out);
#pragma unroll
      for (int k = 0; k < Terms(N); ++k) d_out[k] = fmaf(p[k], normal, d_out[k]);
    }
  }

  // Horner in l_1 from power D1 down to B.
  template <int B>
  __device__ static __forceinline__ void Middle(const float* c, const AffineMap<D2>& map,
                                                float* out, float* d_out) {
    const float* row = c + B * (D2 + 1);
    if constexpr (B == D1) {
      Inner(row, map, out);
      if constexpr (kDerivative) InnerDerivative(row, map, d_out);
    } else {
      constexpr int kN = D2 + D1 - B - 1;
      float p[Terms(kN)], d_p[Terms(kN)], r[Terms(D2)], d_r[Terms(D2)];
      Middle<B + 1>(c, map, p, d_p);
      Inner(row, map, r);
      if constexpr (kDerivative) InnerDerivative(row, map, d_r);
      Step<kN, D2>(p, d_p, map.l[1], map.normal[1], r, d_r, out, d_out);
    }
  }

  // Horner in l_0 from power D0 down to A.
  template <int A>
  __device__ static __forceinline__ void Outer(const float* c, const AffineMap<D2>& map, float* out,
                                               float* d_out) {
    const float* plane = c + A * (D1 + 1) * (D2 + 1);
    if constexpr (A == D0) {
      Middle<0>(plane, map, out, d_out);
    } else {
      constexpr int kN = D2 + D1 + D0 - A - 1;
      float p[Terms(kN)], d_p[Terms(kN)], r[Terms(D1 + D2)], d_r[Terms(D1 + D2)];
      Outer<A + 1>(c, map, p, d_p);
      Middle<0>(plane, map, r, d_r);
      Step<kN, D1 + D2>(p, d_p, map.l[0], map.normal[0], r, d_r, out, d_out);
    }
  }
};

// From powers to Taylor coefficients: p[At(i, j)] *= i! j!, the derivative d^i/dx^i d^j/dt^j at 0.
template <int N>
__device__ __forceinline__ void ToTaylor(float* p) {
  constexpr float kFactorial[11] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800};
#pragma unroll
  for (int i = 0; i <= N; ++i) {
#pragma unroll
    for (int j = 0; j <= N - i; ++j) p[At(i, j)] *= kFactorial[i] * kFactorial[j];
  }
}

// Replaces the Taylor coefficients of p(x, t) by those of p(x + shear t, t): d/dt becomes d/dt + shear
// d/dx, once for each degree of t.
template <int N>
__device__ __forceinline__ void Shear(float* p, float shear) {
#pragma unroll
  for (int from = 1; from <= N; ++from) {
#pragma unroll
    for (int j = N; j >= from; --j) {
#pragma unroll
      for (int i = 0; i <= N - j; ++i) p[At(i, j)] = fmaf(shear, p[At(i + 1, j - 1)], p[At(i, j)]);
    }
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_POLYNOMIAL_CUH_
