// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bernstein polynomials over a triangle.                      Cui & Feng 2014, formula (3)
//
//   B^n_ijk(b0,b1,b2) = n! / (i! j! k!) b0^i b1^j b2^k,   i + j + k = n,   m = (n+1)(n+2)/2 of them
//
// Order    (n,0,0), (n-1,1,0), (n-1,0,1), (n-2,2,0), …, (0,0,n): i falls, then j falls
// Errors   none: callers pass legal indices
// Threads  pure functions, host and device
#ifndef LATTICED_CORE_FFD_BOX_BERNSTEIN_H_
#define LATTICED_CORE_FFD_BOX_BERNSTEIN_H_

#include "core/base/host_device.h"

namespace latticed {

LATTICED_HD constexpr int BernsteinCount(int n) { return (n + 1) * (n + 2) / 2; }

// Place of (i, j, k) in the order above; n - i rows of 1, 2, … entries lie before it.
LATTICED_HD constexpr int BernsteinIndex(int n, int i, int k) {
  return (n - i) * (n - i + 1) / 2 + k;
}

template <typename T>
LATTICED_HD constexpr T Power(T base, int exponent) {
  T product{1};
  for (int e = 0; e < exponent; ++e) product *= base;
  return product;
}

// B^n_ijk with n = i + j + k. It is zero where an index is negative, as the recurrence of the derivatives needs.
template <typename T>
LATTICED_HD constexpr T Bernstein(int i, int j, int k, T b0, T b1, T b2) {
  if (i < 0 || j < 0 || k < 0) return T{0};
  T multinomial{1};
  // (i+j+k)! / (i! j! k!) as two binomials, each product exact for n <= 10.
  for (int e = 1; e <= j; ++e) multinomial = multinomial * T(i + e) / T(e);
  for (int e = 1; e <= k; ++e) multinomial = multinomial * T(i + j + e) / T(e);
  return multinomial * Power(b0, i) * Power(b1, j) * Power(b2, k);
}

// Derivatives of B^n_ijk by b1 (U) and b2 (V), with b0 = 1 - b1 - b2: along the edges from corner 0 to corners 1 and 2.
template <typename T>
LATTICED_HD constexpr T BernsteinU(int i, int j, int k, T b0, T b1, T b2) {
  return T(i + j + k) * (Bernstein(i, j - 1, k, b0, b1, b2) - Bernstein(i - 1, j, k, b0, b1, b2));
}
template <typename T>
LATTICED_HD constexpr T BernsteinV(int i, int j, int k, T b0, T b1, T b2) {
  return T(i + j + k) * (Bernstein(i, j, k - 1, b0, b1, b2) - Bernstein(i - 1, j, k, b0, b1, b2));
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_BERNSTEIN_H_
