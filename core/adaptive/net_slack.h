// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What rounding in double can take from the bounds of net_curvature.h, where the net is inv(B) times samples of the surface
// at uniform points (core/ffd/stage_matrices.h).
//
//   exact bound <= computed bound + slack
//   slack = e 4 n (n - 1) |inv(B)| (300 X + sum_g (300 + 100 r_g) M_g)         e = 2^-53
//
//   |inv(B)|   the largest sum of magnitudes in a row
//   X          the largest norm of a corner of the mesh
//   g          the lattices whose frames the patch is in
//   M_g        the largest norm of a control point of g that moves the patch, or X
//   r_g        the largest ratio, of the three axes, of a parameter in the patch's knot span to the length of that span
//
// Derivation. A second derivative is n (n - 1) times a sum of at most four net points. A sample is wrong by
// - at most 160 e M_g for the basis of each lattice: degree at most 3, three axes, at most 64 products of four factors with
//   control points relative to one of them, which are up to 2 M_g long;
// - at most 90 e r_g M_g where the parameter is rounded, five times: |dR/du| <= 2 degree M_g / span on each of three axes,
//   because the support of each basis function in it has the patch's span;
// - 4 e X for the point at rest, and with weights 10 e (X + sum M_g) for the product.
// The product with inv(B), of at most 66 columns, rounds by 66 e |inv(B)| (X + sum M_g). The computed inv(B) is itself
// rounded, but samples are those of a net: what counts is |inv(B) B - I|, which is below 2 e |inv(B)| up to n = 10, times the
// largest net point. The rest of 300 stands for products of roundings and for those of the slack itself.
//
// Units    world; control points relative to plan.local_origin
// Threads  immutable
#ifndef LATTICED_CORE_ADAPTIVE_NET_SLACK_H_
#define LATTICED_CORE_ADAPTIVE_NET_SLACK_H_

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/base/host_device.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

// (300 + 100 r_g) M_g, from r_g.
LATTICED_HD inline double SlackOfLattice(double ratio, double largest_norm) {
  return (300 + 100 * ratio) * largest_norm;
}
LATTICED_HD inline double SlackAtRest(double mesh_reach) { return 300 * mesh_reach; }

// The ratio of one axis.
LATTICED_HD inline double KnotRatio(const double* knots, int span) {
  const double begin = std::abs(knots[span]), end = std::abs(knots[span + 1]);
  return (begin > end ? begin : end) / (knots[span + 1] - knots[span]);
}

class NetSlack {
 public:
  // Keeps a reference to the plan.
  explicit NetSlack(const DeformPlan& plan);

  // The norms of control points, relative to the local origin.
  [[nodiscard]] std::vector<double> Norms(std::span<const Vec3d> control_points) const;
  // `norms`: those of Norms.
  [[nodiscard]] double Of(size_t patch, std::span<const double> norms) const;
  // e 4 n (n - 1) |inv(B)|
  double of_net() const { return of_net_; }
  // X
  double mesh_reach() const { return mesh_reach_; }

 private:
  double OfLattice(const LatticeStructure& structure, const KnotSpans& spans,
                   std::span<const double> norms) const;

  const DeformPlan& plan_;
  const double mesh_reach_, of_net_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_NET_SLACK_H_
