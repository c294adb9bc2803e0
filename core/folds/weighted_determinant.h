// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// det J of a patch with vertex weights (core/ffd/weights/) as a Bernstein polynomial on its triangle, in double.
//
//   J     = I + w (J_F - I) + (F - x) grad(w)^T. It is that of a map of space which moves the surface as the weights say, w
//           being constant along the triangle's normal
//   det J = det(C_u, C_v, C_w) / det(e_u, e_v, e_w),   C_a = e_a + w G_a + (grad w . e_a) G
//           G = F - x the offset, G_a its derivatives over the box, e_a the edges of the box at rest
//   On a patch of degree n, each C_a has degree n, and det J has 3 n.
//
// The box's G and G_a come to the triangle by polar forms (triangle_forms.h).
//
// Slack. All weights are positive and sum to 1. So each C_a has an error of at most 300 u B_a, where u = 2^-53,
// B_a = |e_a| + |G_a| + |grad w . e_a| |G|, by the largest components in the box; products add 500 u, and kMostHalvings
// halvings of 27 levels 1,080 u. Of the six products
//   |error| <= 6 * 2,500 u B_u B_v B_w, divided by det(e_u, e_v, e_w).
// A coefficient above the slack proves that the true one is above 0.
//
// Most patches need no polynomial: det J > 0 where |J - I| < 1, and |J - I| <= max w |J_F - I| + |F - x| |grad w|.
//
// Errors   none; where numbers overflow, nothing is proved
// Threads  pure functions
#ifndef LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_
#define LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_

#include <array>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/folds/bernstein_triangle.h"

namespace latticed {

// A knot box of a weighted plan, for its patches.
class WeightedBox {
 public:
  // `offsets`: of the plan's control points from their places at rest.
  WeightedBox(const DeformPlan& plan, uint32_t box, std::span<const Vec3d> offsets);

  // Whether the second bound above proves det J > 0 on a patch of the box.
  [[nodiscard]] bool IsNearRest(size_t patch) const;
  // Sets `determinant` to det J over a patch of the box, and returns the slack.
  [[nodiscard]] double MakeDeterminant(size_t patch, BernsteinTriangle& determinant) const;

 private:
  const DeformPlan& plan_;
  const KnotBox& knots_;
  BezierBox offset_;
  std::array<BezierBox, 3> slopes_;  // by axis
  std::array<Vec3d, 3> edges_;
  double volume_ = 0;         // of the edges; negative in a left-handed frame
  double offset_length_ = 0;  // bounds of |F - x| and of |J_F - I|
  double slope_length_ = 0;
  double most_offset_ = 0;  // the largest components
  std::array<double, 3> most_slope_{};
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_WEIGHTED_DETERMINANT_H_
