// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Composition of a box polynomial with affine maps, one map per lane, exactly.
//
// A bivariate polynomial of degree n is an array of (n+1)(n+2)/2 coefficients, that of x^i t^j at
// At(i, j). They are ordered by degree, so a polynomial of lower degree is a prefix. All loops have constant
// bounds and are unrolled. Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POLYNOMIAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POLYNOMIAL_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POLYNOMIAL_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POLYNOMIAL_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

constexpr int Terms(int degree) { return (degree + 1) * (degree + 2) / 2; }
constexpr int At(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

// out (degree N + 1) = p (degree N) * (l[0] + l[1] x + l[2] t) + r (degree R <= N + 1).
template <int N, int R>
HWY_INLINE void MultiplyLinearAdd(const V* HWY_RESTRICT p, const V* HWY_RESTRICT l,
                                  const V* HWY_RESTRICT r, V* HWY_RESTRICT out) {
  LATTICED_UNROLL for (int degree = 0; degree <= N + 1; ++degree) {
    LATTICED_UNROLL for (int j = 0; j <= degree; ++j) {
      const int i = degree - j;
      V sum = degree <= R ? r[At(i, j)] : hn::Zero(D());
      if (degree <= N) sum = hn::MulAdd(p[At(i, j)], l[0], sum);
      if (i > 0) sum = hn::MulAdd(p[At(i - 1, j)], l[1], sum);
      if (j > 0) sum = hn::MulAdd(p[At(i, j - 1)], l[2], sum);
      out[At(i, j)] = sum;
    }
  }
}

// The affine map of a lane's patch, and the powers of its last coordinate.
struct AffineMap {
  V l[3][3];    // [axis][1, x, t]
  V square[6];  // l[2]^2
  V cube[10];   // l[2]^3
  V normal[3];  // direction of the facet normal; smooth normals only
};

template <int D2>
HWY_INLINE void Powers(AffineMap& map) {
  if constexpr (D2 >= 2) {
    const V zero[1] = {hn::Zero(D())};
    MultiplyLinearAdd<1, 0>(map.l[2], map.l[2], zero, map.square);
    if constexpr (D2 >= 3) MultiplyLinearAdd<2, 0>(map.square, map.l[2], zero, map.cube);
  }
}

// out (degree D2) = sum_c coefficient[first + c] * l2^c
template <int D2>
HWY_INLINE void ComposeLast(const BoxPolynomial& box, const AffineMap& map, int first,
                            int component, V* HWY_RESTRICT out) {
  const V c0 = Coefficient(box, first, component), c1 = Coefficient(box, first + 1, component);
  const V c2 = D2 >= 2 ? Coefficient(box, first + 2, component) : c1;
  const V c3 = D2 >= 3 ? Coefficient(box, first + 3, component) : c1;
  for (int k = 0; k < Terms(D2); ++k) {
    V sum = k == 0 ? c0 : hn::Zero(D());
    if (k < Terms(1)) sum = hn::MulAdd(c1, map.l[2][k], sum);
    if (D2 >= 2 && k < Terms(2)) sum = hn::MulAdd(c2, map.square[k], sum);
    if (D2 >= 3) sum = hn::MulAdd(c3, map.cube[k], sum);
    out[k] = sum;
  }
}

// out (degree D2 - 1): its derivative along map.normal.
template <int D2>
HWY_INLINE void ComposeLastDerivative(const BoxPolynomial& box, const AffineMap& map, int first,
                                      int component, V* HWY_RESTRICT out) {
  const V c1 = hn::Mul(Coefficient(box, first + 1, component), map.normal[2]);
  V c2 = c1, c3 = c1;
  if (D2 >= 2) {
    c2 =
        hn::Mul(hn::Mul(hn::Set(D(), 2.0f), Coefficient(box, first + 2, component)), map.normal[2]);
  }
  if (D2 >= 3) {
    c3 =
        hn::Mul(hn::Mul(hn::Set(D(), 3.0f), Coefficient(box, first + 3, component)), map.normal[2]);
  }
  for (int k = 0; k < Terms(D2 - 1); ++k) {
    V sum = k == 0 ? c1 : hn::Zero(D());
    if (D2 >= 2 && k < Terms(1)) sum = hn::MulAdd(c2, map.l[2][k], sum);
    if (D2 >= 3) sum = hn::MulAdd(c3, map.square[k], sum);
    out[k] = sum;
  }
}

// out = p * l + r by value, and d_out = (p * l + r)' along the normal = d_p * l + p * normal + d_r.
template <int N, int R, bool kDerivative>
HWY_INLINE void HornerStep(const V* p, const V* d_p, const V* l, V normal, const V* r, const V* d_r,
                           V* out, V* d_out) {
  MultiplyLinearAdd<N, R>(p, l, r, out);
  if constexpr (kDerivative) {
    MultiplyLinearAdd<N - 1, R - 1>(d_p, l, d_r, d_out);
    for (int k = 0; k < Terms(N); ++k) {
      d_out[k] = hn::MulAdd(p[k], normal, d_out[k]);
    }
  }
}

// Horner in l1 over b = D1 … B.
template <int D1, int D2, int B, bool kDerivative>
HWY_INLINE void ComposeMiddle(const BoxPolynomial& box, const AffineMap& map, int first,
                              int component, V* out, V* d_out) {
  const int index = first + B * (D2 + 1);
  if constexpr (B == D1) {
    ComposeLast<D2>(box, map, index, component, out);
    if constexpr (kDerivative) ComposeLastDerivative<D2>(box, map, index, component, d_out);
  } else {
    constexpr int kDegree = D2 + D1 - B - 1;
    V p[Terms(kDegree)], d_p[Terms(kDegree)], r[Terms(D2)], d_r[Terms(D2)];
    ComposeMiddle<D1, D2, B + 1, kDerivative>(box, map, first, component, p, d_p);
    ComposeLast<D2>(box, map, index, component, r);
    if constexpr (kDerivative) ComposeLastDerivative<D2>(box, map, index, component, d_r);
    HornerStep<kDegree, D2, kDerivative>(p, d_p, map.l[1], map.normal[1], r, d_r, out, d_out);
  }
}

// Horner in l0 over a = D0 … A: the composed polynomial of one component, degree D0 + D1 + D2.
template <int D0, int D1, int D2, int A, bool kDerivative>
HWY_INLINE void Compose(const BoxPolynomial& box, const AffineMap& map, int component, V* out,
                        V* d_out) {
  constexpr int kStride = (D1 + 1) * (D2 + 1);
  if constexpr (A == D0) {
    ComposeMiddle<D1, D2, 0, kDerivative>(box, map, A * kStride, component, out, d_out);
  } else {
    constexpr int kDegree = D2 + D1 + D0 - A - 1;
    V p[Terms(kDegree)], d_p[Terms(kDegree)], r[Terms(D1 + D2)], d_r[Terms(D1 + D2)];
    Compose<D0, D1, D2, A + 1, kDerivative>(box, map, component, p, d_p);
    ComposeMiddle<D1, D2, 0, kDerivative>(box, map, A * kStride, component, r, d_r);
    HornerStep<kDegree, D1 + D2, kDerivative>(p, d_p, map.l[0], map.normal[0], r, d_r, out, d_out);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POLYNOMIAL_INL_H_
