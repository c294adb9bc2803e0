// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomial of each knot box, relative to the plan's local origin: R - local_origin (core/ffd/box/box_basis.h).
// With weights it is that of the offset, R(x) - x.
// It is computed in double from the control points and rounded to float once.
//
// Threads  pure functions; the constructor does all work that does not depend on control points
#ifndef LATTICED_CORE_CPU_FUSED_BOX_POLYNOMIALS_H_
#define LATTICED_CORE_CPU_FUSED_BOX_POLYNOMIALS_H_

#include <array>
#include <memory>
#include <span>

#include "core/cpu/fused/kernel/fused_kernel.h"
#include "core/ffd/box/box_basis.h"

namespace latticed::fused {

class BoxPolynomials {
 public:
  explicit BoxPolynomials(std::shared_ptr<const DeformPlan> plan);

  // Degrees by permuted axis.
  std::array<int, 3> degree() const { return basis_.degree(); }

  BoxPolynomial Make(uint32_t box, std::span<const Vec3d> control_points) const;

  // What rounding can take from the bounds of the second derivatives of the box's patches (core/adaptive/curvature_slack.h).
  std::array<float, 6> Slack(uint32_t box, std::span<const Vec3d> control_points,
                             Vec3d reach) const;

  // Coordinates of a vertex local to `box`, by permuted axis. For the outside box they come from the world position.
  Vec3d Local(uint32_t box, const PlanVertex& vertex) const;
  // The same for a direction in the world.
  Vec3d LocalDirection(uint32_t box, Vec3d world) const;
  // The derivatives of the world position by box-local coordinates.
  std::array<Vec3d, 3> WorldByLocal(uint32_t box) const;
  // The conormal cof(A) N of a world normal N, where A is the Jacobian of box-local coordinates by world position.
  // The cofactors of the polynomial's Jacobian map it to cof(J) N.
  Vec3d LocalConormal(uint32_t box, Vec3d world_normal) const;

 private:
  // BoxPolynomial::rest.
  std::array<std::array<float, 3>, 4> Rest(uint32_t box) const;
  // The polynomial's coefficients in double, as BoxBasis::Polynomial orders them.
  std::array<Vec3d, BoxBasis::kMostTerms> Coefficients(uint32_t box,
                                                       std::span<const Vec3d> control_points) const;

  std::shared_ptr<const DeformPlan> plan_;
  FrameMap map_;
  BoxBasis basis_;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_BOX_POLYNOMIALS_H_
