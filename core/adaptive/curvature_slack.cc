// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/curvature_slack.h"

namespace latticed {
namespace {

// d^order l^power / dl^order.
double PowerDerivative(double l, int power, int order) {
  double value = 1;
  for (int k = 0; k < order; ++k) value *= power - k;
  for (int k = order; k < power; ++k) value *= l;
  return value;
}

}  // namespace

std::array<double, 6> CurvatureSlack(std::span<const Vec3d> coefficients,
                                     const std::array<int, 3>& degree, Vec3d reach) {
  // The orders of the derivative by each coordinate, and the weight in sum_ab.
  constexpr int kOrders[6][4] = {{2, 0, 0, 1}, {0, 2, 0, 1}, {0, 0, 2, 1},
                                 {1, 1, 0, 2}, {0, 1, 1, 2}, {1, 0, 1, 2}};
  const double roundings = (13 * (degree[0] + degree[1] + degree[2]) + 8) * 0x1p-24;
  std::array<double, 6> slack{};
  for (size_t pair = 0; pair < 6; ++pair) {
    const int* order = kOrders[pair];
    size_t k = 0;
    for (int a = 0; a <= degree[0]; ++a) {
      for (int b = 0; b <= degree[1]; ++b) {
        for (int c = 0; c <= degree[2]; ++c, ++k) {
          slack[pair] += Norm(coefficients[k]) * PowerDerivative(reach.x, a, order[0]) *
                         PowerDerivative(reach.y, b, order[1]) *
                         PowerDerivative(reach.z, c, order[2]);
        }
      }
    }
    slack[pair] *= order[3] * roundings;
  }
  return slack;
}

}  // namespace latticed
