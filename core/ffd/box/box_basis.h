// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The matrices that turn control points into the polynomial of a knot box, in power form about the
// box's centre.
//
//   R(u,v,w) = sum_abc C_abc l0^a l1^b l2^c,   l = (parameter - centre) / width
//   C_abc    = sum_rst M0[r][a] M1[s][b] M2[t][c] P_rst,   P the control points that reach the box
//
// Axes are permuted so that degrees fall (degree()[0] >= degree()[1] >= degree()[2]): 10 kernels serve all 27
// combinations of degrees. The outside box has the identity map, and its l runs over the world bounds of the outside
// pieces.
//
// Units    parameters; world units in the outside box
// Threads  immutable
#ifndef LATTICED_CORE_FFD_BOX_BOX_BASIS_H_
#define LATTICED_CORE_FFD_BOX_BOX_BASIS_H_

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/ffd/box/span_basis.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class BoxBasis {
 public:
  // matrix[r][k]: coefficient of l^k in basis function N_{span - degree + r}.
  using Matrix = SpanBasis;

  explicit BoxBasis(std::shared_ptr<const DeformPlan> plan);

  // The lattice's axis for each permuted axis.
  const std::array<int, 3>& axes() const { return axes_; }
  // Degrees by permuted axis.
  std::array<int, 3> degree() const;
  // The matrices of a permuted axis, one per knot span. They are zero where the span is empty.
  const std::vector<Matrix>& matrices(size_t permuted_axis) const { return basis_[permuted_axis]; }

  // C of a box, relative to the plan's local origin: entry (a (d1 + 1) + b)(d2 + 1) + c for the degrees d of degree().
  static constexpr size_t kMostTerms = 64;
  std::array<Vec3d, kMostTerms> Polynomial(uint32_t box,
                                           std::span<const Vec3d> control_points) const;
  // The same of the offset R(x) - x, from the offsets of control points from their places at rest. It keeps the digits of a
  // small offset. Not of the outside box.
  std::array<Vec3d, kMostTerms> OffsetPolynomial(uint32_t box,
                                                 std::span<const Vec3d> control_points) const;
  // The coordinates l of a vertex, by permuted axis. In the outside box they come from the world position.
  Vec3d Local(uint32_t box, const PlanVertex& vertex) const;

  // By axis of the lattice; in the outside box, of the world. A width is never 0.
  Vec3d Centre(uint32_t box) const;
  Vec3d Width(uint32_t box) const;
  // The gradient of each coordinate l by world position, by permuted axis.
  std::array<Vec3d, 3> Gradients(uint32_t box) const;

 private:
  // C of a box from the points that point(index) returns.
  template <typename Point>
  std::array<Vec3d, kMostTerms> Contract(uint32_t box, const Point& point) const;

  std::shared_ptr<const DeformPlan> plan_;
  std::array<int, 3> axes_;
  std::array<std::vector<Matrix>, 3> basis_;
  std::array<Vec3d, 3> parameter_gradient_;  // by axis of the lattice
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_BOX_BOX_BASIS_H_
