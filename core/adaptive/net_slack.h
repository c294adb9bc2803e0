// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What rounding in double can take from the bounds of net_curvature.h, where the net is inv(B) times samples of the surface
// at uniform points (core/ffd/stage_matrices.h).
//
//   exact bound <= computed bound + slack
//   slack = e 4 n (n - 1) |inv(B)| sum_g (300 + 24 r_g) M_g         e = 2^-53
//
//   |inv(B)|   the largest sum of magnitudes in a row
//   M_g        the largest norm of a control point of lattice g that moves the patch, or of a corner of the mesh
//   r_g        the largest ratio of a knot to the length of a knot span, of the axes of lattice g
//
// Derivation. A second derivative is n (n - 1) times a sum of at most four net points. A sample is wrong by
// - at most 80 e M_g for the basis of each lattice (degree at most 3, three axes, 27 to 64 products of four factors);
// - 12 e r_g M_g where the parameter is rounded: it is a sum of three products, |dR/du| <= 2 degree M / span, three axes;
// - 4 e of the corners for the point at rest, and with weights another 10 e M for the product.
// A product with inv(B) of at most 66 columns rounds by 66 e |inv(B)| M. The sum is below 200 + 12 r_g; it is raised for the
// second copy of each M, the products of roundings and those of the slack itself.
//
// Units    world; control points relative to plan.local_origin
// Threads  immutable
#ifndef LATTICED_CORE_ADAPTIVE_NET_SLACK_H_
#define LATTICED_CORE_ADAPTIVE_NET_SLACK_H_

#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class NetSlack {
 public:
  // Keeps a reference to the plan.
  explicit NetSlack(const DeformPlan& plan);

  // The norms of control points, relative to the local origin.
  [[nodiscard]] std::vector<double> Norms(std::span<const Vec3d> control_points) const;
  // `norms`: those of Norms.
  [[nodiscard]] double Of(size_t patch, std::span<const double> norms) const;
  // By lattice, the plan's own first: what stands before M_g.
  std::span<const double> factors() const { return factors_; }
  // The largest norm of a corner of the mesh.
  double mesh_reach() const { return mesh_reach_; }

 private:
  double Largest(const LatticeStructure& structure, const KnotSpans& spans,
                 std::span<const double> norms) const;

  const DeformPlan& plan_;
  const double mesh_reach_;
  std::vector<double> factors_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_NET_SLACK_H_
