// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/bernstein_volume.h"

#include <algorithm>
#include <cmath>

namespace latticed {
namespace {

// The coefficients as `outer` blocks of `count` rows of `stride` numbers: a row per coefficient on one axis.
struct CoefficientRows {
  size_t outer, count, stride;
};
CoefficientRows CoefficientRowsOf(const BernsteinVolume& volume, size_t axis) {
  CoefficientRows rows{1, volume.count[axis], 1};
  for (size_t a = 0; a < axis; ++a) rows.stride *= volume.count[a];
  for (size_t a = axis + 1; a < 3; ++a) rows.outer *= volume.count[a];
  return rows;
}

void AverageInto(double* __restrict to, const double* __restrict from, size_t count) {
  for (size_t i = 0; i < count; ++i) to[i] = 0.5 * (to[i] + from[i]);
}

// The value of `count` Bernstein coefficients that lie `stride` apart.
double UnivariateValue(const double* coefficients, size_t count, size_t stride, double t) {
  std::array<double, BernsteinVolume::kMostCount> c;
  for (size_t i = 0; i < count; ++i) c[i] = coefficients[i * stride];
  for (size_t left = count; left > 1; --left) {
    for (size_t i = 0; i + 1 < left; ++i) c[i] = (1 - t) * c[i] + t * c[i + 1];
  }
  return c[0];
}

}  // namespace

double BernsteinVolume::Least() const {
  double least = coefficients[0];
  for (size_t i = 1; i < size(); ++i) {
    if (!(coefficients[i] >= least)) least = coefficients[i];
    if (std::isnan(least)) return least;
  }
  return least;
}

double BernsteinVolume::Corner(unsigned corner) const {
  size_t index = 0, stride = 1;
  for (size_t a = 0; a < 3; ++a) {
    if (((corner >> a) & 1u) != 0) index += stride * (count[a] - 1);
    stride *= count[a];
  }
  return coefficients[index];
}

double BernsteinVolume::Value(Vec3d l) const {
  std::array<double, kMostCount * kMostCount> plane;
  std::array<double, kMostCount> line;
  const size_t row = count[0], layer = count[0] * count[1];
  for (size_t i = 0; i < layer; ++i) {
    plane[i] = UnivariateValue(&coefficients[i], count[2], layer, l.z);
  }
  for (size_t i = 0; i < row; ++i) line[i] = UnivariateValue(&plane[i], count[1], row, l.y);
  return UnivariateValue(line.data(), count[0], 1, l.x);
}

size_t BernsteinVolume::SteepestAxis() const {
  size_t steepest = 0;
  double most = -1;
  for (size_t axis = 0; axis < 3; ++axis) {
    const CoefficientRows rows = CoefficientRowsOf(*this, axis);
    const size_t block = rows.count * rows.stride;
    double step = 0;
    for (size_t o = 0; o < rows.outer; ++o) {
      const double* c = &coefficients[o * block];
      for (size_t i = 0; i + rows.stride < block; ++i) {
        step = std::max(step, std::abs(c[i + rows.stride] - c[i]));
      }
    }
    const double slope = static_cast<double>(rows.count - 1) * step;
    if (slope > most) {
      most = slope;
      steepest = axis;
    }
  }
  return steepest;
}

void BernsteinVolume::Halve(size_t axis, BernsteinVolume& upper) {
  upper.count = count;
  const CoefficientRows rows = CoefficientRowsOf(*this, axis);
  const size_t block = rows.count * rows.stride;
  for (size_t o = 0; o < rows.outer; ++o) {
    double* c = &coefficients[o * block];
    double* last = &upper.coefficients[o * block] + (block - rows.stride);
    for (size_t level = 0;; ++level, last -= rows.stride) {
      // The last row is a coefficient of the upper half, row `level` one of the lower half.
      std::copy_n(c + (block - rows.stride), rows.stride, last);
      if (level + 1 == rows.count) break;
      for (size_t row = rows.count; --row > level;) {
        AverageInto(c + row * rows.stride, c + (row - 1) * rows.stride, rows.stride);
      }
    }
  }
}

}  // namespace latticed
