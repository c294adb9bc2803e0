// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// det J of a part of a knot box as a Bernstein polynomial, in double.
//
//   J     = d R / d x, x the rest world. det J is 1 where the lattice is at rest, and 0 or less where space is flattened or
//           turned inside out
//   det J = det(R_u, R_v, R_w) / det(x_u, x_v, x_w), degree 3 n - 1 on an axis of degree n
//   R_u   = the derivative of box_slopes.h
//   product of Bernstein polynomials: c_k binomial(p + q, k) = sum_i+j=k a_i binomial(p, i) b_j binomial(q, j)
//                                                                                Farouki & Rajan 1988, (44)
//
// Slack. With u = 2^-53 and D_a the largest component of the differences of axis a, in the box's control points:
//   a difference, over its knots and times the box's width                                                5 u
//   weights of the restriction, all of them positive: 3 levels of 6 operations and a sum of 4, per axis     66 u
//   so each of the three gradients has an error of at most 71 u D_a, and their product                     213 u
//   binomials, and a sum of at most 36 * 2 + 48 * 3 products                                               235 u
//   the frame's factor, and every binomial of the result                                                     2 u
// times the sum of the moduli of the six products, 6 D_u D_v D_w, whose weights are positive and sum to 1. A halving takes
// means of coefficients below 6 D_u D_v D_w, in at most 8 levels: 8 u each. With kMostHalvings = 40 of them
//   |error| <= 6 (450 + 320) u D_u D_v D_w = 5.2e-13 D_u D_v D_w, divided by det(x_u, x_v, x_w).
// A coefficient above the slack proves that the true one is above 0.
//
// Errors   none: lattices are validated where they are made. Coefficients overflow to infinity or NaN where a box is more
//          than 1e100 times thinner than the frame; then nothing is proved
// Threads  pure functions
#ifndef LATTICED_CORE_FOLDS_BOX_DETERMINANT_H_
#define LATTICED_CORE_FOLDS_BOX_DETERMINANT_H_

#include <array>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/folds/bernstein_volume.h"
#include "core/folds/box_slopes.h"

namespace latticed {

// Halvings of a BernsteinVolume that the slack allows for.
inline constexpr int kMostHalvings = 40;

// Sets `determinant` to det J over the part, and returns the slack.
[[nodiscard]] double MakeBoxDeterminant(const LatticeStructure& structure,
                                        std::span<const Vec3d> control_points, const BoxPart& part,
                                        BernsteinVolume& determinant);

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_BOX_DETERMINANT_H_
