// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The control points of a spline in a larger spline space of one axis: more knots, a higher degree, or both.
//
//   target control point i of degree N = blossom of degree N of the spline's polynomial at the knots i + 1 … i + N
//   blossom of degree N of a polynomial of degree n = mean of its blossoms of degree n over all n of the N arguments
//
// The blossom of degree n on a knot span is a product of n matrices of de Boor's algorithm, each at an argument of its own:
// Lyche & Mørken, Spline Methods, §2.2 and §4.2; Ramshaw 1989.
//
// Errors   none: the spaces must be legal (lattice.h)
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_SUM_KNOT_REFINEMENT_H_
#define LATTICED_CORE_FFD_SUM_KNOT_REFINEMENT_H_

#include <array>
#include <cstddef>
#include <vector>

namespace latticed {

// A spline space of one axis, over the domain [knots[degree], knots[size]].
struct AxisSpace {
  int degree = 0;
  std::vector<double> knots;

  int size() const { return static_cast<int>(knots.size()) - degree - 1; }
  double begin() const { return knots[static_cast<size_t>(degree)]; }
  double end() const { return knots[knots.size() - 1 - static_cast<size_t>(degree)]; }
};

// What a target control point is of the source's: weights of consecutive ones, none where it is 0.
struct RefinedPoint {
  int first = 0;
  int count = 0;
  std::array<double, 4> weight{};
};

// One entry per control point of `target`. Both spaces have the same parameter. The source is 0 beyond its domain, and the
// target contains the source: its degree is no lower, and it has each knot of the source inside its own domain, and each end
// of the source there, so often that it is no smoother. Knots of both that are equal must be so bit for bit.
[[nodiscard]] std::vector<RefinedPoint> Refine(const AxisSpace& source, const AxisSpace& target);

// Of a lattice, per axis.
using RefinedAxes = std::array<std::vector<RefinedPoint>, 3>;

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_SUM_KNOT_REFINEMENT_H_
