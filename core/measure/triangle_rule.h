// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Quadrature on a triangle: the conical product of two Gauss-Legendre rules of m points.
//                                                   Stroud, Approximate Calculation of Multiple Integrals, 1971, §2.5
//
//   integral of f over the triangle / its area = sum over points of weight f(barycentrics)
//
// It has m^2 points, all inside, and is exact for polynomials of total degree 2 m - 2.
//
// Errors   none: 1 <= m
// Threads  pure function
#ifndef LATTICED_CORE_MEASURE_TRIANGLE_RULE_H_
#define LATTICED_CORE_MEASURE_TRIANGLE_RULE_H_

#include <array>
#include <vector>

namespace latticed {

struct TriangleRulePoint {
  std::array<double, 3> barycentrics{};
  double weight = 0;
};
[[nodiscard]] std::vector<TriangleRulePoint> MakeTriangleRule(int m);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_TRIANGLE_RULE_H_
