// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomial of a knot box in power form about the box centre.
//
//   R(u,v,w) - local_origin = sum_abc C_abc l0^a l1^b l2^c,   l = (parameter - centre) / width
//
// Computed in double from control points, rounded once. The outside box is the identity map: its l
// runs over the world bounds of the outside pieces.
//
// Threads  pure; construction does all that does not depend on control points
#ifndef LATTICED_CORE_CPU_BOX_POLYNOMIALS_H_
#define LATTICED_CORE_CPU_BOX_POLYNOMIALS_H_

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/cpu/fused_kernel.h"
#include "core/ffd/deform_plan.h"

namespace latticed::fused {

class BoxPolynomials {
 public:
  explicit BoxPolynomials(std::shared_ptr<const DeformPlan> plan);

  // Axis of the lattice behind each permuted axis; degrees fall along it.
  const std::array<int, 3>& axes() const { return axes_; }
  std::array<int, 3> degree() const;

  BoxPolynomial Make(uint32_t box, std::span<const Vec3d> control_points) const;

  // Box-local coordinates of a vertex in `box`, axes permuted. By world position outside.
  Vec3d Local(uint32_t box, const PlanVertex& vertex) const;
  // The same of a world direction.
  Vec3d LocalDirection(uint32_t box, Vec3d world) const;

 private:
  // matrix[r][k]: coefficient of l^k in basis function N_{span - degree + r}.
  using BasisMatrix = std::array<std::array<double, 4>, 4>;
  BasisMatrix MakeBasis(int axis, int span) const;
  Vec3d Width(uint32_t box) const;

  std::shared_ptr<const DeformPlan> plan_;
  FrameMap map_;
  std::array<int, 3> axes_;
  std::array<std::vector<BasisMatrix>, 3> basis_;  // [axis][span]
  std::array<Vec3d, 3> world_gradient_;            // d parameter_axis / d world
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_BOX_POLYNOMIALS_H_
