// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A part of a B-spline volume as a tensor-product Bézier volume. It lies in the hull of its
// coefficients; its derivatives lie in the hull of their differences.
//                                                                       Ramshaw 1989, blossoming
//
//   R(lower + l (upper - lower)) = sum_ijk B_ijk b_i(l_u) b_j(l_v) b_k(l_w),   l in [0, 1]^3
//   B_ijk = f(lower_u^(n-i) upper_u^i; …), f the polar form of the knot box's polynomial
//
// Errors   none
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_BOX_BEZIER_BOX_H_
#define LATTICED_CORE_FFD_BOX_BEZIER_BOX_H_

#include <array>
#include <span>

#include "core/base/bounds.h"
#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"

namespace latticed {

// A row per Bernstein coefficient, a column per control point; zero beyond the degree.
using BezierMatrix = std::array<std::array<double, limits::kMaxDegree + 1>, limits::kMaxDegree + 1>;

// The matrix that turns the coefficients of N_{span - degree} … N_{span} on one axis into Bernstein coefficients over
// [lower, upper]. Inside the knot interval no entry is negative, and each row sums to 1.
[[nodiscard]] BezierMatrix BezierMatrixOf(std::span<const double> knots, int degree, int span,
                                          double lower, double upper);

struct BezierBox {
  static constexpr size_t kMostPoints = limits::kMaxDegree + 1;

  std::array<int, 3> degree{};
  Vec3d points[kMostPoints][kMostPoints][kMostPoints];  // [k][j][i]

  [[nodiscard]] Bounds Hull() const;
  // The hull of d R / d l along one axis.
  [[nodiscard]] Bounds SlopeHull(size_t axis) const;
};

// Returns the part [lower, upper] of the knot box with the given spans.
[[nodiscard]] BezierBox RestrictVolume(const LatticeStructure& structure,
                                       std::span<const Vec3d> control_points,
                                       const std::array<int, 3>& span, Vec3d lower, Vec3d upper);

// The bounds of the control points that influence a knot box. They are wider than the Hull of its BezierBox, and
// cheaper to compute.
[[nodiscard]] Bounds ControlHull(const LatticeStructure& structure,
                                 std::span<const Vec3d> control_points,
                                 const std::array<int, 3>& span);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_BEZIER_BOX_H_
