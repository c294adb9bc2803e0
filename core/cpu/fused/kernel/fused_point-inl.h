// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates R and its Jacobian at one point per lane, from the polynomial of the point's box.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POINT_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POINT_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POINT_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// One step of Horner's rule in l, sum * l + next. `sum` holds the value and its derivatives by the inner
// coordinates, kEntries in all; with kSlopes the derivative by l itself comes after them. The value's
// bits do not depend on kSlopes.
template <int kEntries, bool kSlopes>
HWY_INLINE void JetStep(V l, const V* next, bool first, V* sum) {
  if constexpr (kSlopes) sum[kEntries] = first ? sum[0] : hn::MulAdd(sum[kEntries], l, sum[0]);
  LATTICED_UNROLL for (int i = 0; i < kEntries; ++i) sum[i] = hn::MulAdd(sum[i], l, next[i]);
}

template <int D2, bool kSlopes>
HWY_INLINE void EvaluateLine(const BoxPolynomial& box, const V* l, int first, int component,
                             V* jet) {
  jet[0] = Coefficient(box, first + D2, component);
  LATTICED_UNROLL for (int c = D2 - 1; c >= 0; --c) {
    const V next = Coefficient(box, first + c, component);
    JetStep<1, kSlopes>(l[2], &next, c == D2 - 1, jet);
  }
}

template <int D1, int D2, bool kSlopes>
HWY_INLINE void EvaluatePlane(const BoxPolynomial& box, const V* l, int first, int component,
                              V* jet) {
  constexpr int kEntries = kSlopes ? 2 : 1;
  EvaluateLine<D2, kSlopes>(box, l, first + D1 * (D2 + 1), component, jet);
  LATTICED_UNROLL for (int b = D1 - 1; b >= 0; --b) {
    V next[kEntries];
    EvaluateLine<D2, kSlopes>(box, l, first + b * (D2 + 1), component, next);
    JetStep<kEntries, kSlopes>(l[1], next, b == D1 - 1, jet);
  }
}

// jet[0] = R, and with kSlopes jet[1 + i] = dR / dl_(2 - i), of one component.
template <int D0, int D1, int D2, bool kSlopes>
HWY_INLINE void EvaluatePoint(const BoxPolynomial& box, const V* l, int component, V* jet) {
  constexpr int kEntries = kSlopes ? 3 : 1, kStride = (D1 + 1) * (D2 + 1);
  EvaluatePlane<D1, D2, kSlopes>(box, l, D0 * kStride, component, jet);
  LATTICED_UNROLL for (int a = D0 - 1; a >= 0; --a) {
    V next[kEntries];
    EvaluatePlane<D1, D2, kSlopes>(box, l, a * kStride, component, next);
    JetStep<kEntries, kSlopes>(l[0], next, a == D0 - 1, jet);
  }
}

// cof(J) n = n0 J1 x J2 + n1 J2 x J0 + n2 J0 x J1, from the jets of R's three components.
HWY_INLINE V3 CofactorTimes(const V (&jet)[3][4], V n0, V n1, V n2) {
  const V3 j0{jet[0][3], jet[1][3], jet[2][3]}, j1{jet[0][2], jet[1][2], jet[2][2]},
      j2{jet[0][1], jet[1][1], jet[2][1]};
  // n0 J1 x J2 + n1 J2 x J0 = (n0 J1 - n1 J0) x J2.
  const V3 side{hn::MulSub(n0, j1.x, hn::Mul(n1, j0.x)), hn::MulSub(n0, j1.y, hn::Mul(n1, j0.y)),
                hn::MulSub(n0, j1.z, hn::Mul(n1, j0.z))};
  const V3 sum = CrossLanes(side, j2), last = CrossLanes(j0, j1);
  return {hn::MulAdd(n2, last.x, sum.x), hn::MulAdd(n2, last.y, sum.y),
          hn::MulAdd(n2, last.z, sum.z)};
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_POINT_INL_H_
