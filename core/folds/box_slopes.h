// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The derivatives of a B-spline volume over a part of a knot box, as Bernstein coefficients, in double.
//
//   R_a = d R / d l_a, l from 0 to 1 over the knot box: the B-spline of the differences
//         n (P_i - P_i-1) (width of the box) / (t_i+n - t_i)                     Piegl & Tiller, The NURBS Book, §3.3
//
// The derivatives come before the restriction to the part, so that the part may be flat: the bounds of one triangle are.
//
// Errors   none
// Threads  immutable
#ifndef LATTICED_CORE_FOLDS_BOX_SLOPES_H_
#define LATTICED_CORE_FOLDS_BOX_SLOPES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/lattice.h"

namespace latticed {

// A part of a knot box, in parameters. It may be flat.
struct BoxPart {
  std::array<int, 3> span{};
  Vec3d lower, upper;
};

// All of a knot box.
[[nodiscard]] BoxPart WholeBox(const LatticeStructure& structure, const std::array<int, 3>& span);

// The control points that influence a knot box.
[[nodiscard]] BezierBox ControlBox(const LatticeStructure& structure,
                                   std::span<const Vec3d> control_points,
                                   const std::array<int, 3>& span);
// Turns them into the differences of an axis, whose hull holds R_a over the knot box. Returns their largest component.
double Differentiate(const LatticeStructure& structure, const std::array<int, 3>& span, size_t axis,
                     BezierBox& grid);

// The largest size(p) of the box's points p, at least 0; not a number if one is.
template <class Size>
double LargestPoint(const BezierBox& box, const Size& size) {
  double largest = 0;
  for (int k = 0; k <= box.degree[2]; ++k) {
    for (int j = 0; j <= box.degree[1]; ++j) {
      for (int i = 0; i <= box.degree[0]; ++i) {
        const double of_point = size(box.points[k][j][i]);
        if (std::isnan(of_point)) return of_point;
        largest = std::max(largest, of_point);
      }
    }
  }
  return largest;
}
[[nodiscard]] inline double LargestComponent(Vec3d v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

class BoxSlopes {
 public:
  BoxSlopes(const LatticeStructure& structure, std::span<const Vec3d> control_points,
            const BoxPart& part);

  // Sets `slopes` to R_a. Returns the largest component of the differences.
  double Along(size_t axis, BezierBox& slopes) const;

 private:
  const LatticeStructure& structure_;
  std::array<int, 3> span_;
  BezierBox box_;                                           // its control points
  std::array<std::array<BezierMatrix, 3>, 2> restrict_to_;  // [of the derivative][axis]
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_BOX_SLOPES_H_
