// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tolerances in numbers: the level of an edge, and what a view can promise.
//
//   level        the least k with E <= 6 t 4^k: E the largest second derivative along the edge in all its patches, t
//                the part of the tolerance that is left for curvature
//   t            max(tolerance - point error, point error / 2): finer triangles would say nothing beyond the grid
//   point error  3e-7 D + sqrt(3)/2 step: no pattern makes it smaller. step is 0 for floats
//   view error   point error + max over patches of PatternError
//
// With levels so chosen, every side of a pattern has M <= sum |d_a d_b| 6 t 4^k_ab <= 6 t (pattern_split.h), and every
// triangle an error of at most t (Lemma 1 of certificate.h). 3e-7 D is the accuracy of a point of any pipeline, D as
// in core/README.md. Rounding to the grid moves a point by at most half a step on each axis.
//
// D here is the diagonal of the quantisation box, which contains all that D measures. Thus t is a function of
// tolerance, bits and box: an edit that keeps the box changes the levels of edges near it only. Bits meet a tolerance if
// the point error is at most two thirds of it. If it is more, the view error may exceed the tolerance.
//
// Units    world
// Threads  pure functions
#ifndef LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_
#define LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/host_device.h"
#include "core/base/limits.h"
#include "core/ffd/plan/quantisation_box.h"

namespace latticed {

inline constexpr double kPointAccuracy = 3e-7;  // of D

// At most limits::kMaxEdgeLevel, whether that suffices or not. A bound that is not a number has that level, but an infinite
// t asks for nothing: a tolerance that is doubled ends there. t is positive.
template <typename T>
LATTICED_HD constexpr uint8_t EdgeLevel(T largest_curvature, T t) {
  if (t == std::numeric_limits<T>::infinity()) return 0;
  T reach = 6 * t;
  uint8_t level = 0;
  while (level < limits::kMaxEdgeLevel && !(largest_curvature <= reach)) {
    reach *= 4;
    ++level;
  }
  return level;
}

// position_bits: 0 for floats.
inline double PointError(const QuantisationBox& box, int position_bits) {
  constexpr double kSquareRootOf3 = 1.732050807568878;  // rounded up
  const double step = position_bits > 0 ? box.step(position_bits) : 0;
  return kSquareRootOf3 * (kPointAccuracy * box.range + 0.5 * step);
}

// t: the part of the tolerance that is left for curvature.
inline double CurvatureTolerance(double tolerance, const QuantisationBox& box, int position_bits) {
  const double point_error = PointError(box, position_bits);
  return std::max(tolerance - point_error, 0.5 * point_error);
}

// The part for curvature of a tolerance, and then of its doubles: what a view tries until it has few enough points. Each
// evaluation begins with the tolerance itself, so that its result depends on control points and box alone. An infinite
// part is the last one: it leaves the corners of patches.
class ToleranceSteps {
 public:
  ToleranceSteps(double tolerance, const QuantisationBox& box, int position_bits)
      : tolerance_(tolerance),
        box_(box),
        position_bits_(position_bits),
        curvature_(CurvatureTolerance(tolerance, box, position_bits)) {}

  double curvature() const { return curvature_; }
  // Doubles the tolerance until the part for curvature is another one.
  void Double() {
    const double before = curvature_;
    while (curvature_ == before && std::isfinite(before)) {
      tolerance_ *= 2;
      curvature_ = CurvatureTolerance(tolerance_, box_, position_bits_);
    }
  }

 private:
  double tolerance_;
  const QuantisationBox box_;
  const int position_bits_;
  double curvature_;
};

// position_bits: 0 for floats.
inline bool MeetsTolerance(double tolerance, const QuantisationBox& box, int position_bits) {
  return 3 * PointError(box, position_bits) <= 2 * tolerance;
}

// The least position bits that meet the tolerance; nullopt if limits::kMaxPositionBits do not.
[[nodiscard]] inline std::optional<int> LeastPositionBits(double tolerance,
                                                          const QuantisationBox& box) {
  for (int bits = limits::kMinPositionBits; bits <= limits::kMaxPositionBits; ++bits) {
    if (MeetsTolerance(tolerance, box, bits)) return bits;
  }
  return std::nullopt;
}

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_EDGE_LEVELS_H_
