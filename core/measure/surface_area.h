// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The area of the exact deformed surface, and its derivatives by all control points.
//
//   A        = sum over patches of the integral of |F_s x F_t| ds dt
//   dA/dP_i  = integral of dN_i/ds (F_t x n) + dN_i/dt (n x F_s),   n = (F_s x F_t) / |F_s x F_t|
//
// With vertex weights F is x + w (F - x), and N_i is w N_i. Under several lattices F is x plus what all of them move x.
//
// The integrand is the root of a polynomial, so patches are integrated by two rules (triangle_rule.h). Where these
// differ by more than the tolerance allows, the patch is quartered and each quarter is integrated alone. The
// difference of the two rules estimates the error of the coarser one; the finer one's result is taken.
//
// Units    world units squared
// Errors   what `stop` returns
// Threads  pure function, on the threads of `arena`; null: on the caller's alone. The bits do not depend on their number
#ifndef LATTICED_CORE_MEASURE_SURFACE_AREA_H_
#define LATTICED_CORE_MEASURE_SURFACE_AREA_H_

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

struct SurfaceArea {
  double area = 0;
  double error = 0;             // estimated
  std::vector<Vec3d> gradient;  // dA/dP, one for each control point; empty if it was not asked for
};

// `tolerance` is the largest error, as a fraction of the area. A quarter of a quarter … is not divided further than 24
// times: where the surface is folded to a line, the error then stays above the tolerance, and `error` says so.
[[nodiscard]] absl::StatusOr<SurfaceArea> MeasureArea(const DeformPlan& plan,
                                                      std::span<const Vec3d> control_points,
                                                      double tolerance, bool with_gradient,
                                                      StopCheck stop = NeverStop,
                                                      CpuArena* arena = nullptr);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_SURFACE_AREA_H_
