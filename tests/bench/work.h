// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts the multiply-adds of scalars that a method needs: for lower bounds, and for formula (20).
//
//   fused    per component; M(d) = (d+1)(d+2)/2 coefficients of a bivariate polynomial of degree d
//     composition  Horner in u, then v, then w. A step multiplies by a linear form of three terms:
//                     + sum M(nu+nv … n-1))
//     a row        collapse and its slope, two rows at once by parity: n(n+1)/2 + n(n-1)/2 = n²
//     a point      position and both slopes, points x and -x at once: ((n+1) + n + n) / 2
//     normal       12 per point: cross product, square, scaling
//   Below 4 segments direct evaluation takes less: R and its three derivatives, per component
//     (nv+1)(nw+1)(2nu-1) + (nw+1)(3nv-1) + 4nw-1, and 18 for both tangents.
//   Not counted: frames for slivers and shared points (82 multiply-adds per point instead of 63),
//     comparisons, conversions and addresses. No form of this method needs less than the count.
//
//   two-stage        Method 1: (6), (17)      3 m²f + 9 m q f
//                    Method 2: (24), (25)     3 m²q + 9 m q f     equal at f = q
//   (20) as printed counts the product of a number and a vector once: m²f + 3mqf against
//   3 m²q + 3mqf, equal at f = 3q.
#ifndef LATTICED_TESTS_BENCH_WORK_H_
#define LATTICED_TESTS_BENCH_WORK_H_

#include <algorithm>
#include <array>

namespace latticed::bench {

inline constexpr double kNormalWork = 12;

// M(first) + … + M(last - 1).
constexpr double Coefficients(int first, int last) {
  double sum = 0;
  for (int d = first; d < last; ++d) sum += 0.5 * (d + 1) * (d + 2);
  return sum;
}

// For x, y and z of one patch.
constexpr double CompositionWork(std::array<int, 3> degree) {
  const int u = degree[0], uv = u + degree[1], n = uv + degree[2];
  return 9 * ((degree[1] + 1) * (degree[2] + 1) * Coefficients(0, u) +
              (degree[2] + 1) * Coefficients(u, uv) + Coefficients(uv, n));
}

// For one point with its tangents, from the lattice.
constexpr double DirectWork(std::array<int, 3> degree) {
  const int u = degree[0], v = degree[1], w = degree[2];
  return 3 * ((v + 1) * (w + 1) * (2 * u - 1) + (w + 1) * (3 * v - 1) + 4 * w - 1) + 18;
}

// For one patch with facet normals, by the cheaper form.
constexpr double FusedWork(std::array<int, 3> degree, int segments) {
  const int n = degree[0] + degree[1] + degree[2];
  const double points = 0.5 * (segments + 1) * (segments + 2);
  const double composed = CompositionWork(degree) + 3.0 * n * n * (segments + 1) +
                          points * (1.5 * (3 * n + 1) + kNormalWork);
  return std::min(composed, points * (DirectWork(degree) + kNormalWork));
}

// Product (25) of one patch.
constexpr double ProductWork(int n, int segments) {
  return 9 * Coefficients(n, n + 1) * Coefficients(segments, segments + 1);
}

struct TwoStageWork {
  double method1 = 0, method2 = 0;
};
constexpr TwoStageWork ScalarWork(double m, double q, double f) {
  return {3 * m * m * f + 9 * m * q * f, 3 * m * m * q + 9 * m * q * f};
}
constexpr TwoStageWork Formula20Work(double m, double q, double f) {
  return {m * m * f + 3 * m * q * f, 3 * m * m * q + 3 * m * q * f};
}

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_WORK_H_
