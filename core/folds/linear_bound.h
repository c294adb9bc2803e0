// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A polynomial volume as a linear function of y in [-1, 1]^3, within a remainder.
//
//   p(y) = centre + sum_b y_b slope_b, within radius by component
//
// A linear function has its own values at the nodes y = 2 i / d - 1 as Bernstein coefficients. So the difference lies between
// the least and the largest difference of a coefficient from the value at its node. The slopes are those of least squares.
//
// Errors   none
// Threads  pure function
#ifndef LATTICED_CORE_FOLDS_LINEAR_BOUND_H_
#define LATTICED_CORE_FOLDS_LINEAR_BOUND_H_

#include <array>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"

namespace latticed {

struct LinearBound {
  Vec3d centre, radius;
  std::array<Vec3d, 3> slope;
};

[[nodiscard]] LinearBound BoundLinearly(const BezierBox& box);

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_LINEAR_BOUND_H_
