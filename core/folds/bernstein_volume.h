// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A polynomial over the unit cube by its Bernstein coefficients. Between its least and its largest coefficient lie all of
// its values; the eight corner coefficients are values.             Farin, Curves and Surfaces for CAGD, chapters 5 and 16
//
//   f(l) = sum_ijk c_ijk b_i(l_u) b_j(l_v) b_k(l_w),   b_i(t) = binomial(d, i) t^i (1 - t)^(d - i)
//
// Layout  c_ijk at i + count_u (j + count_v k), count = degree + 1 per axis
// Errors  none
// Threads plain data
#ifndef LATTICED_CORE_FOLDS_BERNSTEIN_VOLUME_H_
#define LATTICED_CORE_FOLDS_BERNSTEIN_VOLUME_H_

#include <array>
#include <cstddef>

#include "core/base/limits.h"
#include "core/base/vec.h"

namespace latticed {

struct BernsteinVolume {
  // det J of a lattice of degree n has degree 3 n - 1 on an axis: nine coefficients for cubics.
  static constexpr size_t kMostCount = 3 * limits::kMaxDegree;
  static constexpr size_t kMostCoefficients = kMostCount * kMostCount * kMostCount;

  std::array<size_t, 3> count{1, 1, 1};
  std::array<double, kMostCoefficients> coefficients;

  [[nodiscard]] size_t size() const { return count[0] * count[1] * count[2]; }
  // NaN if a coefficient is.
  [[nodiscard]] double Least() const;
  // The value at a corner: bit a of `corner` says that l is 1 on axis a.
  [[nodiscard]] double Corner(unsigned corner) const;
  // By de Casteljau's rule, for l in the unit cube.
  [[nodiscard]] double Value(Vec3d l) const;
  // The axis along which neighbouring coefficients differ most, times the degree: the bound of the slope.
  [[nodiscard]] size_t SteepestAxis() const;
  // Keeps the half where l <= 1/2 on the axis, and makes `upper` the other half.
  void Halve(size_t axis, BernsteinVolume& upper);
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_BERNSTEIN_VOLUME_H_
