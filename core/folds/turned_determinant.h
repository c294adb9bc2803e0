// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// det J of a patch under lattices that are turned against each other, as a Bernstein polynomial on its triangle, in double.
//
//   J   = I + sum over g (J_g - I)        g: the lattices whose frames hold the patch, m of them
//   J_g = sum over a R_a r_a^T            R_a: the derivatives over the knot box that holds the patch (box_slopes.h),
//                                         r_a: the gradients of the box's coordinates, dual to its edges e_a
//   On a patch of degree n, J has degree n - 1, and det J has 3 (n - 1). Lattices of a lower degree are elevated.
//
// J is that of DirectFfd, evaluated without rounding: the vertices' parameters in each lattice are what the plan says.
//
// Slack. With u = 2^-53, D_a the largest component of the differences of R_a in the box's control points, C_a the cross product
// e_b x e_c with moduli instead of numbers, p_a = C_a / |det(e)|, and k = |e_u| . C_u / |det(e)|: 1 for edges along the world's
// axes, below 1.2 for other orthogonal edges.
//   differences, and their restriction to the box: 6 u + 66 u (box_determinant.h)                           72 u
//   polar forms of 8 arguments: 6 u for a corner's place, and 2 u for a product and a sum of each            64 u
//   their sums of 4 numbers per axis, and of at most 60 products of multinomials                             72 u
//   r_a is within (3 + 5 k) u p_a of the true one; times R_a, over the width of the box, and three sums      12 u + 5 k u
//   an elevation is a sum of at most 28 products                                                             29 u
//   the sum over lattices                                                                                     8 u
// So a coefficient of column c of J has an error of at most (260 + 5 k) u B_c,
//   B_c = |1 - m| + sum over g and a of D_a p_a[c]
// which bounds the column, because all weights are positive and sum to 1. Three columns have 780 u + 15 k u, sums of at most
// 2 * 45 and of 3 * 45 products 230 u, the multinomials of the result 15 u, and kMostHalvings halvings of 24 levels 960 u.
// Of the six products
//   |error| <= 6 (2,200 + 20 k) u B_x B_y B_z, with room for products of errors.
// A coefficient above the slack proves that the true one is above 0.
//
// With vertex weights (core/ffd/weights/vertex_weights.h)
//   J   = I + w sum over g (J_g - I) + (sum over g G_g) grad(w)^T
//         G_g: the offset R_g - x, where x is the volume of the lattice's identity points
//   Its columns have degree n, and det J has 3 n. As in weighted_determinant.h, G_g comes from the offsets of control points,
//   and J_g from differences. Column c of J is that of I, w times the column of A = sum over g (J_g - I), and grad(w)_c G:
//   A, as above, with |m| in place of |1 - m| in B_c, which is then A_c                           260 u A_c + 5 k u A_c
//   w A: sums of 3 products, the divisions of multinomials being in the 15 u below                             6 u A_c
//   G_g over the box, with H_g the largest component of the offsets: the offsets, and the restriction         67 u H_g
//   polar forms of 9 arguments, their sums, an elevation, and the sum over lattices        72 u + 72 u + 29 u + 8 u H_g
//   times grad(w)_c                                                                                            2 u H_g
//   the sum of the three                                                                                   3 u of each
// So a coefficient of column c has an error of at most (275 + 5 k) u B_c, B_c = 1 + A_c + |grad(w)_c| sum over g H_g. Three
// columns have 825 u + 15 k u, sums of at most 2 * 55 and of 3 * 55 products 280 u, the multinomials 15 u, and kMostHalvings
// halvings of 27 levels 1,080 u. Of the six products
//   |error| <= 6 (2,500 + 20 k) u B_x B_y B_z, with room for products of errors.
//
// Most patches need no polynomial: det J > 0 where |J - I| < 1, and |J_g - I| <= sum over a |R_a - e_a| |r_a|, where the
// coefficients of R_a over the box bound the first factor. With weights
//   |J - I| <= max w sum over g |J_g - I| + |grad w| sum over g |G_g|.
//
// Errors   none; where numbers overflow, nothing is proved
// Threads  one at a time: what is known of boxes is kept from patch to patch
#ifndef LATTICED_CORE_FOLDS_TURNED_DETERMINANT_H_
#define LATTICED_CORE_FOLDS_TURNED_DETERMINANT_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/turned/turned_lattice.h"
#include "core/folds/bernstein_triangle.h"
#include "core/folds/frame_gradients.h"
#include "core/folds/triangle_forms.h"

namespace latticed {

// Keeps references to the plan and the control points.
class TurnedPatches {
 public:
  // `offsets`: of the control points from their places at rest, if the plan is weighted.
  TurnedPatches(const DeformPlan& plan, std::span<const Vec3d> control_points,
                std::span<const Vec3d> offsets = {});

  // Whether a patch of the plan is in the frame of a turned lattice.
  [[nodiscard]] static bool IsReached(const DeformPlan& plan, size_t patch);
  // Whether the second bound above proves det J > 0 on the patch.
  [[nodiscard]] bool IsNearRest(size_t patch);
  // Sets `determinant` to det J over the patch, and returns the slack.
  [[nodiscard]] double MakeDeterminant(size_t patch, BernsteinTriangle& determinant);
  // What it keeps of the boxes of a plan.
  [[nodiscard]] static size_t MostBytes(const DeformPlan& plan);

 private:
  // One lattice, and the knot box in it that was asked for last.
  struct Lattice {
    const LatticeStructure* structure = nullptr;
    std::span<const Vec3d> points, offsets;  // no offsets without weights
    FrameGradients frame;
    std::vector<double> rises;    // bounds of |J_g - I| by box, kUnknown where none was asked for
    std::vector<double> reaches;  // bounds of |G_g|, likewise, with weights

    KnotSpans spans = kNoSpans;
    SlopesOfBox box;         // R_a and D_a
    BezierBox offset;        // G_g, with weights
    double most_offset = 0;  // H_g
  };

  static Lattice MakeLattice(const LatticeStructure& structure, std::span<const Vec3d> points,
                             std::span<const Vec3d> offsets);
  static void Enter(Lattice& lattice, const KnotSpans& spans);
  static double ReachOf(const Lattice& lattice);
  // The columns of J_g by the world's axes on the triangle; adds D_a p_a to `bounds`.
  static std::array<VectorForm, 3> Columns(const Lattice& lattice, const TriangleInBox& corners,
                                           Vec3d& bounds);

  // Turns the columns of A on a patch, in the boxes that the lattices have entered, into those of J, and A_c into B_c.
  void Weigh(size_t patch, std::span<const size_t> lattices, std::array<VectorForm, 3>& column,
             Vec3d& bounds) const;

  KnotSpans SpansOf(size_t lattice, size_t patch) const;
  TriangleInBox CornersOf(size_t lattice, size_t patch) const;

  const DeformPlan& plan_;
  std::vector<Lattice> lattices_;  // the plan's own, then the turned ones
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_TURNED_DETERMINANT_H_
