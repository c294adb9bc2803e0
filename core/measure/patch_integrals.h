// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The integrals of enclosed_volume.h by exact quadrature on each patch, for surfaces that have no moments: with vertex weights w
// (core/ffd/weights/), or under lattices that are turned against each other (core/ffd/turned/). D is what all lattices move x.
//
//   P = x + w D,   D = sum_g (F_g - x)
//   V = 1/3 integral P . n dA          dV/dP_i   = integral w N_i n dA
//   S_j = 1/4 integral P_j P . n dA    dS_j/dP_i = integral w N_i P_j n dA
//
// On a patch of degree n the integrands are polynomials of degree 3 n - 2 at most and, those of S, 4 n - 2. A rule
// (triangle_rule.h) integrates each patch exactly; the sums over points of l^p m^q n^r, by core/points, give the derivatives.
// Patches that share knot boxes are evaluated together (patch_runs.h).
// Unlike moments, this costs time for each patch: with weights 121 points at degree 2 x 2 x 2, 225 at 3 x 3 x 3; for S 196 and
// 400. A patch that no lattice reaches, or whose corners all have the weight 0, rests, and costs next to nothing.
//
// Units    world units
// Errors   what `stop` returns. Callers check that the surface is closed
// Threads  pure function, on the threads of `arena`; null: on the caller's alone. The bits do not depend on their number
#ifndef LATTICED_CORE_MEASURE_PATCH_INTEGRALS_H_
#define LATTICED_CORE_MEASURE_PATCH_INTEGRALS_H_

#include <array>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

struct PatchIntegrals {
  Vec3d origin;  // P is relative to this point of the surface
  double volume = 0;
  Vec3d moment;                                       // S
  std::vector<Vec3d> volume_gradient;                 // for each control point
  std::vector<std::array<Vec3d, 3>> moment_gradient;  // [i][j] = dS_j / dP_i
};
// Without `with_moment`, S and its derivatives are left empty; without `with_gradient`, all derivatives.
[[nodiscard]] absl::StatusOr<PatchIntegrals> IntegratePatches(
    const DeformPlan& plan, std::span<const Vec3d> control_points, bool with_moment,
    StopCheck stop = NeverStop, CpuArena* arena = nullptr, bool with_gradient = true);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_PATCH_INTEGRALS_H_
