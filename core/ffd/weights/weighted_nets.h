// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bézier control nets of patches with vertex weights, from those of the lattice's deformation F.
//
//   P = x + w (F - x),   P_A = sum over corners c of A_c / (n + 1) (x_c + w_c (F - x)_(A - c)),   |A| = n + 1
//
// F has degree n on a patch, x and w are linear, so P has degree n + 1. (F - x)_B = F_B - sum of B_c / n x_c.
//
// Layout   a net of degree n has (n + 1)(n + 2) / 2 points of 3 doubles: T_{n,0,0}, T_{n-1,1,0}, …, T_{0,0,n}
// Errors   none
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_NETS_H_
#define LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_NETS_H_

#include <cstddef>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

// The degree of a patch of the deformed surface.
[[nodiscard]] inline int NetDegree(const DeformPlan& plan) {
  return plan.patch_degree() + (plan.is_weighted() ? 1 : 0);
}
// `nets` are those of F of patches from `first` on. The plan must be weighted.
[[nodiscard]] std::vector<double> WeighNets(const DeformPlan& plan, size_t first,
                                            std::span<const double> nets);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_WEIGHTS_WEIGHTED_NETS_H_
