// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the first point of the exact deformed surface on a ray.
//
// In the ray's frame z runs along the ray, and a point of the surface is on the ray where x = y = 0. Control points are
// transformed to that frame. The hull of the Bézier coefficients of a part of the volume then bounds x, y and z of all
// patches in it, and the hull of their differences bounds the derivatives. A best-first search by the least z goes down
// the PatchTree, then bisects patches. A part is
//
//   left out   where its bounds miss the ray, or lie behind the nearest hit
//   solved     where |I - Y J| < 1/2 for every Jacobian J of (x, y) in it, with Y the inverse in the middle: it has at
//              most one root, which Newton's iteration finds    Toth 1985, On ray tracing parametric surfaces
//   a hit      where it is smaller than kTouch of the surface: the ray touches it, or runs along it
//
// With weights the coefficients are those of the offset, and weights/weighted_triangle.h turns its bounds into those of the
// surface.
//
// Rounding may put a root just outside of its patch. Its barycentrics are clamped, and it is a hit if the clamped point
// is within kReach of the ray: no ray passes between two patches that share an edge.
//
// Units    world units; kTouch and kReach relative to the largest extent of the surface's bounds
// Errors   what `stop` returns
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_PICK_SURFACE_PICK_H_
#define LATTICED_CORE_FFD_PICK_SURFACE_PICK_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/pick/patch_tree.h"
#include "core/ffd/plan/deform_plan.h"

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

// nullopt where the ray meets no patch. `tree` must be of `plan`; `stop` is called every few thousand steps.
[[nodiscard]] absl::StatusOr<std::optional<SurfaceHit>> PickSurface(
    const DeformPlan& plan, const PatchTree& tree, std::span<const Vec3d> control_points,
    const Ray& ray, StopCheck stop = NeverStop);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PICK_SURFACE_PICK_H_
