// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// det J of a patch with vertex weights (core/ffd/weights/) as a Bernstein polynomial on its triangle, in double.
//
//   J     = I + w (J_F - I) + (F - x) grad(w)^T. It is that of a map of space which moves the surface as the weights say, w
//           being constant along the triangle's normal
//   det J = det(C_u, C_v, C_w) / det(e_u, e_v, e_w),   C_a = e_a + w G_a + (grad w . e_a) G
//           e_a the edges of the box at rest; G = F - x the offset, where x is the volume of the plan's identity points;
//           G_a = R_a - e_a its derivatives over the box, where R_a are those of F (box_slopes.h)
//   On a patch of degree n, each C_a has degree n, and det J has 3 n.
//
// G_a does not come from G: of a lattice that is moved far away G is large, and its rounding would be in all differences.
// Differences of control points stay small. The box's G and G_a come to the triangle by polar forms (triangle_forms.h).
//
// Slack. With u = 2^-53, the largest components D_a of the differences of R_a in the box's control points, E_a of e_a, H of the
// control points' offsets, and s_a = |grad w| . |e_a| with moduli instead of numbers:
//   R_a over the box, from the differences (box_determinant.h)                             72 u D_a
//   e_a: two widths, a quotient and a product                                              4 u E_a
//   their difference G_a                                                                   1 u (D_a + E_a)
//   G over the box: the offsets, and the restriction                                       67 u H
//   polar forms of 9 arguments: 6 u for a corner's place, and 2 u for a product and a sum  72 u (D_a + E_a) and 72 u H
//   their sums of 4 numbers per axis, and of at most 60 products of multinomials           72 u (D_a + E_a) and 72 u H
//   w G_a, a sum of 3 products                                                             6 u (D_a + E_a)
//   e_a times a multinomial                                                                8 u E_a
//   grad w . e_a, and its product with G                                                   8 u s_a H
//   the sum of the three                                                                   2 u of each
// So a coefficient of C_a has an error of at most 300 u B_a, B_a = D_a + E_a + s_a H, which bounds C_a, because all weights are
// positive and sum to 1. Three columns have 900 u, products 500 u, and kMostHalvings halvings of 27 levels 1,080 u. Of the six
// products
//   |error| <= 6 * 2,500 u B_u B_v B_w, divided by det(e_u, e_v, e_w).
// The rounding of the divisor is a factor that all coefficients share. A coefficient above the slack proves that the true one
// is above 0.
//
// Most patches need no polynomial: det J > 0 where |J - I| < 1, and |J - I| <= max w |J_F - I| + |F - x| |grad w|. The control
// points and their differences bound these; so do the coefficients over the box, more closely.
//
// Errors   none; where numbers overflow, nothing is proved
// Threads  one at a time: what patches need of the box is made for the first of them
#ifndef LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_
#define LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_

#include <array>
#include <optional>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/folds/bernstein_triangle.h"

namespace latticed {

// A knot box of a weighted plan, for its patches. Keeps references to all that it is made of.
class WeightedBox {
 public:
  // `offsets`: of the control points from their places at rest.
  WeightedBox(const DeformPlan& plan, uint32_t box, std::span<const Vec3d> control_points,
              std::span<const Vec3d> offsets);

  // Whether the second bound above proves det J > 0 on a patch of the box.
  [[nodiscard]] bool IsNearRest(size_t patch);
  // Sets `determinant` to det J over a patch of the box, and returns the slack.
  [[nodiscard]] double MakeDeterminant(size_t patch, BernsteinTriangle& determinant);

 private:
  // Bounds of |F - x| and of |J_F - I| in the box.
  struct Bound {
    double offset = 0, rise = 0;
  };
  // Over the box.
  struct Coefficients {
    BezierBox offset;
    std::array<BezierBox, 3> slopes;  // G_a
    Bound bound;
  };

  [[nodiscard]] bool IsWithin(const Bound& bound, size_t patch) const;
  const Coefficients& Restrict();
  // What the slopes along an axis add to a bound of |J_F - I|.
  [[nodiscard]] double RiseOf(const BezierBox& slopes, size_t axis) const;

  const DeformPlan& plan_;
  const KnotBox& knots_;
  std::span<const Vec3d> control_points_, offsets_;
  std::array<Vec3d, 3> edges_;
  double volume_ = 0;       // of the edges; negative in a left-handed frame
  double most_offset_ = 0;  // H and D_a of the slack
  std::array<double, 3> most_slope_{};
  Bound by_control_points_;
  std::optional<Coefficients> coefficients_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_
