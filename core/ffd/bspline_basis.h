// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// B-spline basis functions by Cox and de Boor's recurrence.
//                                                      Piegl & Tiller, The NURBS Book, A2.1-2.3
//
//   On span k (knots[k] <= u <= knots[k+1], knots[k] < knots[k+1]) the degree + 1 functions
//   N_{k-degree} … N_k are not zero everywhere; values[r] = N_{k-degree+r}(u).
//
// Loops have constant bounds and a guard, so that compilers unroll them and keep the arrays in a device's registers.
//
// Errors   none: callers pass a non-empty span of valid knots
// Threads  pure functions, host and device
#ifndef LATTICED_CORE_FFD_BSPLINE_BASIS_H_
#define LATTICED_CORE_FFD_BSPLINE_BASIS_H_

#include "core/base/host_device.h"
#include "core/base/limits.h"

namespace latticed {

// Returns the non-empty span that holds u. A u outside the domain [knots[degree], knots[size]] counts as the
// nearer end. A u on a knot belongs to the span below it (the lower box), and at the domain's begin to the first.
LATTICED_HD constexpr int FindLowerSpan(const double* knots, int degree, int size, double u) {
  int span = degree;
  while (knots[span + 1] == knots[span]) ++span;  // the first non-empty one
  for (int k = span; k < size && knots[k] < u; ++k) {
    if (knots[k + 1] > knots[k]) span = k;
  }
  return span;
}

template <typename T>
LATTICED_HD constexpr void EvaluateBasis(const T* knots, int degree, int span, T u, T* values) {
  T left[limits::kMaxDegree + 1]{}, right[limits::kMaxDegree + 1]{};
  values[0] = T{1};
  for (int j = 1; j <= limits::kMaxDegree; ++j) {
    if (j > degree) break;
    left[j] = u - knots[span + 1 - j];
    right[j] = knots[span + j] - u;
    T saved{0};
    for (int r = 0; r < j; ++r) {
      const T term = values[r] / (right[r + 1] + left[j - r]);
      values[r] = saved + right[r + 1] * term;
      saved = left[j - r] * term;
    }
    values[j] = saved;
  }
}

// First derivatives: d/du N_{k-degree+r} = degree (N^{degree-1}_{i} / (t_{i+degree} - t_i) - …).
template <typename T>
LATTICED_HD constexpr void EvaluateBasisDerivatives(const T* knots, int degree, int span, T u,
                                                    T* derivatives) {
  T lower[limits::kMaxDegree + 1]{};
  EvaluateBasis(knots, degree - 1, span, u, lower);
  for (int r = 0; r <= limits::kMaxDegree; ++r) {
    if (r > degree) break;
    const int i = span - degree + r;
    T d{0};
    if (r > 0) d += lower[r - 1] / (knots[i + degree] - knots[i]);
    if (r < degree) d -= lower[r] / (knots[i + degree + 1] - knots[i + 1]);
    derivatives[r] = T(degree) * d;
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BSPLINE_BASIS_H_
