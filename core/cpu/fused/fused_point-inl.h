// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates R and its Jacobian at one point per lane, from the polynomial of the point's box.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_FUSED_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_FUSED_POINT_INL_H_
#undef LATTICED_CORE_CPU_FUSED_FUSED_POINT_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_FUSED_POINT_INL_H_
#endif

#include "core/cpu/fused/fused_lanes-inl.h"

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

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_POINT_INL_H_
