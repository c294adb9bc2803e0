// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A polynomial of degree d on a triangle, by Bernstein coefficients: sum of c_ij d! / (i! j! k!) b0^i b1^j b2^k, k = d - i - j.
//
// Layout   the coefficient of i, j at i (d + 1) + j; entries with i + j > d are not used
// Threads  plain data
#ifndef LATTICED_CORE_FOLDS_BERNSTEIN_TRIANGLE_H_
#define LATTICED_CORE_FOLDS_BERNSTEIN_TRIANGLE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/base/limits.h"

namespace latticed {

struct BernsteinTriangle {
  static constexpr size_t kMostDegree =
      9 * limits::kMaxDegree;  // of three factors, each of the degree of a patch

  size_t degree = 0;
  std::array<double, (kMostDegree + 1) * (kMostDegree + 1)> coefficients;

  double& at(size_t i, size_t j) { return coefficients[i * (degree + 1) + j]; }
  double at(size_t i, size_t j) const { return coefficients[i * (degree + 1) + j]; }
  void CopyTo(BernsteinTriangle& other) const {
    other.degree = degree;
    std::copy_n(coefficients.begin(), (degree + 1) * (degree + 1), other.coefficients.begin());
  }

  // NaN if any coefficient is.
  double Least() const {
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i <= degree; ++i) {
      for (size_t j = 0; i + j <= degree; ++j) {
        if (!(at(i, j) >= least)) least = at(i, j);
        if (std::isnan(least)) return least;
      }
    }
    return least;
  }
  double Corner(size_t corner) const {
    return corner == 0 ? at(degree, 0) : corner == 1 ? at(0, degree) : at(0, 0);
  }

  // Splits the edge from corner 0 to corner 1 in its middle, which becomes corner 2 of both halves: their corners are
  // (2, 0, middle), which takes the place of this one, and (1, 2, middle). So the next halving splits another edge.
  void Halve(BernsteinTriangle& second) {
    BernsteinTriangle level;
    CopyTo(level);
    second.degree = degree;
    for (size_t r = 0; r <= degree; ++r) {
      const size_t left = degree - r;
      for (size_t m = 0; m <= left; ++m) {
        at(left - m, m) = level.at(m, 0);
        second.at(m, left - m) = level.at(0, m);
      }
      for (size_t i = 0; i < left; ++i) {
        for (size_t j = 0; i + j < left; ++j) {
          level.at(i, j) = 0.5 * (level.at(i + 1, j) + level.at(i, j + 1));
        }
      }
    }
  }

  // By de Casteljau's rule.
  double Value(const std::array<double, 3>& barycentrics) const {
    BernsteinTriangle level;
    CopyTo(level);
    for (size_t left = degree; left > 0; --left) {
      for (size_t i = 0; i < left; ++i) {
        for (size_t j = 0; i + j < left; ++j) {
          level.at(i, j) = barycentrics[0] * level.at(i + 1, j) +
                           barycentrics[1] * level.at(i, j + 1) + barycentrics[2] * level.at(i, j);
        }
      }
    }
    return level.at(0, 0);
  }
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_BERNSTEIN_TRIANGLE_H_
