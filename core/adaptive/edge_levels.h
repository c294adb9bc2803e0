// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tolerances in numbers: the level of an edge, and what a view can promise.
//
//   level           the least k with E <= 6 t 4^k, E the largest second derivative along the edge in all its patches, t
//                   the part of the tolerance that is left for curvature
//   view error      max over patches of PatternError + 3e-7 D + sqrt(3)/2 step <= tolerance
//   t               tolerance - 3e-7 D - sqrt(3)/2 step
//
// With levels so chosen, every side of a pattern has M <= sum |d_a d_b| 6 t 4^k_ab <= 6 t (pattern_split.h), and every
// triangle an error of at most t (Lemma 1 of certificate.h). 3e-7 D is the accuracy of a point of the fused pipeline, D as in
// core/README.md. Rounding to a grid moves a point by at most half a step on each axis; step is 0 for floats.
//
// Units    world
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_
#define LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_

#include <cstdint>
#include <optional>

#include "core/base/host_device.h"
#include "core/base/limits.h"
#include "core/ffd/quantisation_box.h"

namespace latticed {

inline constexpr double kPointAccuracy = 3e-7;              // of D
inline constexpr double kGridRounding = 0.866025403784439;  // sqrt(3)/2, of a step; rounded up

// At most limits::kMaxEdgeLevel, whether that suffices or not. Where t <= 0, every curved edge has that level. A bound
// that is not a number has it as well.
template <typename T>
LATTICED_HD constexpr uint8_t EdgeLevel(T largest_curvature, T t) {
  T reach = 6 * (t > 0 ? t : T{0});
  uint8_t level = 0;
  while (level < limits::kMaxEdgeLevel && !(largest_curvature <= reach)) {
    reach *= 4;
    ++level;
  }
  return level;
}

// What no pattern can make smaller. step: of the grid, or 0.
constexpr double PointError(double diagonal, double step) {
  return kPointAccuracy * diagonal + kGridRounding * step;
}

// The part of a tolerance that is left for curvature; not positive where it cannot be met.
constexpr double CurvatureTolerance(double tolerance, double diagonal, double step) {
  return tolerance - PointError(diagonal, step);
}

// The least position bits whose grid in `box` leaves a part of the tolerance for curvature; nullopt if not even
// limits::kMaxPositionBits do.
[[nodiscard]] inline std::optional<int> LeastPositionBits(double tolerance, double diagonal,
                                                          const QuantisationBox& box) {
  for (int bits = limits::kMinPositionBits; bits <= limits::kMaxPositionBits; ++bits) {
    if (CurvatureTolerance(tolerance, diagonal, box.step(bits)) > 0) return bits;
  }
  return std::nullopt;
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_
