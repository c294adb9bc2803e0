// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bounds of the exact deformed surface.
//
// A patch lies in the hull of its Bezier control points, and has their corners. What cannot reach beyond the farthest point
// known is left out: first knot boxes and groups of patches, by the hull of the restricted volume (bezier_box.h), then
// patches, and parts of them, which are halved by de Casteljau's rule. The distance from hull to surface falls with the
// square of a part's size. With vertex weights a patch has one degree more, and hulls are those of weighted_triangle.h.
//
// Units    world units. Each bound is attained by the surface, and nothing is farther out by more than kBoundsTolerance of
//          its largest extent
// Errors   what `stop` returns
// Threads  pure function; under turned lattices on the threads of `arena`, or on the caller's alone if it is null
#ifndef LATTICED_CORE_MEASURE_SURFACE_BOUNDS_H_
#define LATTICED_CORE_MEASURE_SURFACE_BOUNDS_H_

#include <span>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/stop_check.h"
#include "core/ffd/pick/patch_tree.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

inline constexpr double kBoundsTolerance = 1e-9;

[[nodiscard]] absl::StatusOr<Bounds> MeasureBounds(const DeformPlan& plan, const PatchTree& tree,
                                                   std::span<const Vec3d> control_points,
                                                   StopCheck stop = NeverStop,
                                                   CpuArena* arena = nullptr);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_SURFACE_BOUNDS_H_
