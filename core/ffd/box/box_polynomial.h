// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers for the powers l^p m^q n^r of the local coordinates of a knot box: the coefficients of its polynomial, or sums.
//
//   R = origin + sum_pqr C_pqr l^p m^q n^r,   (l, m, n) each in [-1/2, 1/2], 0 at the box's centre
//
// Layout   [p][q][r][component], doubles without padding; kernels of devices read the same bytes
// Threads  plain data
#ifndef LATTICED_CORE_FFD_BOX_BOX_POLYNOMIAL_H_
#define LATTICED_CORE_FFD_BOX_BOX_POLYNOMIAL_H_

#include <cstddef>

#include "core/base/limits.h"
#include "core/base/vec.h"

namespace latticed {

inline constexpr size_t kPowers = limits::kMaxDegree + 1;

// Zero beyond the degree.
struct BoxNumbers {
  double at[kPowers][kPowers][kPowers][3] = {};
};

struct BoxPolynomial {
  Vec3d origin;
  BoxNumbers coefficients;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_BOX_POLYNOMIAL_H_
