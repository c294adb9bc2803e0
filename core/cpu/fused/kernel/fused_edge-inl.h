// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates the inner points of edges, with the same bits from either end: from the edge's own polynomial,
// or one by one when points are few (fused_direct-inl.h).
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_EDGE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_EDGE_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_EDGE_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_EDGE_INL_H_
#endif

#include "core/cpu/fused/kernel/fused_point-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// out (degree N + 1) = p (degree N) * (m + d tau) + r (degree R): univariate.
template <int N, int R>
HWY_INLINE void MultiplyLinearAdd1(const V* p, V m, V d, const V* r, V* out) {
  LATTICED_UNROLL for (int k = 0; k <= N + 1; ++k) {
    V sum = k <= R ? r[k] : hn::Zero(D());
    if (k <= N) sum = hn::MulAdd(p[k], m, sum);
    if (k > 0) sum = hn::MulAdd(p[k - 1], d, sum);
    out[k] = sum;
  }
}

template <int D2, int C>
HWY_INLINE void EdgeLast(const BoxPolynomial& box, const V* m, const V* d, int first, int component,
                         V* out) {
  const V c = Coefficient(box, first + C, component);
  if constexpr (C == D2) {
    out[0] = c;
  } else {
    V p[D2 - C];
    EdgeLast<D2, C + 1>(box, m, d, first, component, p);
    MultiplyLinearAdd1<D2 - C - 1, 0>(p, m[2], d[2], &c, out);
  }
}

template <int D1, int D2, int B>
HWY_INLINE void EdgeMiddle(const BoxPolynomial& box, const V* m, const V* d, int first,
                           int component, V* out) {
  if constexpr (B == D1) {
    EdgeLast<D2, 0>(box, m, d, first + B * (D2 + 1), component, out);
  } else {
    constexpr int kDegree = D2 + D1 - B - 1;
    V p[kDegree + 1], r[D2 + 1];
    EdgeMiddle<D1, D2, B + 1>(box, m, d, first, component, p);
    EdgeLast<D2, 0>(box, m, d, first + B * (D2 + 1), component, r);
    MultiplyLinearAdd1<kDegree, D2>(p, m[1], d[1], r, out);
  }
}

// Composes one component with an edge's line: a polynomial in tau of degree D0 + D1 + D2. Exchanging the
// edge's ends changes the sign of d, and exactly that of every odd coefficient. Both patches of an edge
// therefore get the same bits, whichever way each runs along it.
template <int D0, int D1, int D2, int A>
HWY_INLINE void ComposeEdge(const BoxPolynomial& box, const V* m, const V* d, int component,
                            V* out) {
  constexpr int kStride = (D1 + 1) * (D2 + 1);
  if constexpr (A == D0) {
    EdgeMiddle<D1, D2, 0>(box, m, d, A * kStride, component, out);
  } else {
    constexpr int kDegree = D2 + D1 + D0 - A - 1;
    V p[kDegree + 1], r[D1 + D2 + 1];
    ComposeEdge<D0, D1, D2, A + 1>(box, m, d, component, p);
    EdgeMiddle<D1, D2, 0>(box, m, d, A * kStride, component, r);
    MultiplyLinearAdd1<kDegree, D1 + D2>(p, m[0], d[0], r, out);
  }
}

// point(tau) = midpoint + tau * direction, tau in [-1/2, 1/2]. Exchanging the ends keeps the midpoint and
// changes the sign of the direction, both exactly.
struct EdgeLine {
  V midpoint[3], direction[3];
  EdgeLine(const V* from, const V* to) {
    for (size_t a = 0; a < 3; ++a) {
      midpoint[a] = hn::Mul(hn::Set(D(), 0.5f), hn::Add(from[a], to[a]));
      direction[a] = hn::Sub(to[a], from[a]);
    }
  }

  // tau of the k-th of `segments` + 1 points. Points k and `segments` - k must have the same |tau|, and
  // k / segments - 1/2 would be rounded differently for the two.
  static HWY_INLINE V Tau(int k, int segments) {
    const bool low = 2 * k < segments;
    const float tau =
        static_cast<float>(low ? segments - k : k) / static_cast<float>(segments) - 0.5f;
    return hn::Set(D(), low ? -tau : tau);
  }
  HWY_INLINE void Place(int k, int segments, V* point) const {
    const V t = Tau(k, segments);
    for (size_t a = 0; a < 3; ++a) point[a] = hn::MulAdd(direction[a], t, midpoint[a]);
  }
};

// Calls store(k, component, value) for the inner points k = 1 … segments - 1 of an edge, which lie
// on the polynomial composed with its line.
template <int D0, int D1, int D2, class StorePoint>
HWY_INLINE void ComposedEdgePoints(const BoxPolynomial& box, const EdgeLine& line, int segments,
                                   const StorePoint& store) {
  constexpr int kN = D0 + D1 + D2;
  const D d;
  for (int c = 0; c < 3; ++c) {
    V p[kN + 1];
    ComposeEdge<D0, D1, D2, 0>(box, line.midpoint, line.direction, c, p);
    for (int low = 1; 2 * low <= segments; ++low) {
      const int high = segments - low;
      const float tau = static_cast<float>(high) / static_cast<float>(segments) - 0.5f;
      const V t = hn::Set(d, tau), t2 = hn::Set(d, tau * tau);
      V even = p[kN - kN % 2], odd = p[kN - 1 + kN % 2];
      LATTICED_UNROLL for (int k = kN - kN % 2 - 2; k >= 0; k -= 2) {
        even = hn::MulAdd(even, t2, p[k]);
      }
      LATTICED_UNROLL for (int k = kN - 3 + kN % 2; k >= 1; k -= 2) {
        odd = hn::MulAdd(odd, t2, p[k]);
      }
      store(static_cast<size_t>(low), static_cast<size_t>(c), hn::NegMulAdd(odd, t, even));
      if (high != low) {
        store(static_cast<size_t>(high), static_cast<size_t>(c), hn::MulAdd(odd, t, even));
      }
    }
  }
}

// The same, with R evaluated at each point: the bits of groups that fused_direct-inl.h evaluates.
template <int D0, int D1, int D2, class StorePoint>
HWY_INLINE void DirectEdgePoints(const BoxPolynomial& box, const EdgeLine& line, int segments,
                                 const StorePoint& store) {
  for (int k = 1; k < segments; ++k) {
    V place[3], value;
    line.Place(k, segments, place);
    for (int c = 0; c < 3; ++c) {
      EvaluatePoint<D0, D1, D2, false>(box, place, c, &value);
      store(static_cast<size_t>(k), static_cast<size_t>(c), value);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_EDGE_INL_H_
