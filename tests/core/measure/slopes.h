// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Derivatives along a line of control points, by differences.
#ifndef LATTICED_TESTS_CORE_MEASURE_SLOPES_H_
#define LATTICED_TESTS_CORE_MEASURE_SLOPES_H_

#include <functional>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace latticed::testing {

inline std::vector<Vec3d> Moved(std::vector<Vec3d> points, double amount,
                                std::span<const Vec3d> moves) {
  for (size_t i = 0; i < points.size(); ++i) points[i] += amount * moves[i];
  return points;
}

// The slope at 0. Exact for a cubic, as the volume is on a line.
inline double CubicSlope(const std::function<double(double)>& value, double h) {
  return (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_MEASURE_SLOPES_H_
