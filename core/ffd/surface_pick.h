// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The first point of the exact deformed surface on a ray.
//
// In the ray's frame, x and y across it and z along it, a point of the surface is on the ray where
// x = y = 0. Control points are put into that frame; the hull of the Bézier coefficients of a part
// of the volume then bounds x, y and z of all patches in it, and that of their differences the
// derivatives. A best-first search by the least z goes down the PatchTree, then bisects patches:
//
//   the bounds miss the ray, or lie behind what was hit                              left out
//   |I - Y J| < 1/2 for every Jacobian J of (x, y) in it, Y the inverse in the middle: one root at
//   most, which Newton's iteration finds                 Toth 1985, On ray tracing parametric surfaces
//   the part is smaller than kTouch of the surface: the ray touches it, or runs along it      a hit
//
// A root may lie beyond the patch by rounding: what is within kReach of the ray after its
// barycentrics were clamped is hit, so that no ray slips through an edge.
//
// Units    world units; kTouch and kReach relative to the largest extent of the surface's bounds
// Errors   what `stop` says
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_SURFACE_PICK_H_
#define LATTICED_CORE_FFD_SURFACE_PICK_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/deform_plan.h"
#include "core/ffd/patch_tree.h"

namespace latticed {

struct Ray {
  Vec3d origin;
  Vec3d direction;  // finite and not zero, of any length
};

struct SurfaceHit {
  uint32_t patch = 0;
  std::array<double, 3> barycentrics{};  // in the patch; 0 to 1, their sum is 1
};

inline constexpr double kTouch = 2e-10;
inline constexpr double kReach = 1e-10;

// nullopt where the ray meets no patch. `tree` is of the plan; `stop` is asked every few thousand
// steps.
[[nodiscard]] absl::StatusOr<std::optional<SurfaceHit>> PickSurface(
    const DeformPlan& plan, const PatchTree& tree, std::span<const Vec3d> control_points,
    const Ray& ray, StopCheck stop = NeverStop);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_SURFACE_PICK_H_
