// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume that the exact deformed surface encloses, its centroid, and their derivatives by all control points.
//
//   V        = 1/3 integral x . n dA                  S_j = integral over the inside of x_j = 1/4 integral x_j x . n dA
//   dV/dP_i  = integral N_i n dA                      dS_j/dP_i = integral N_i x_j n dA
//   C        = S / V                                  dC_j/dP_i = (dS_j/dP_i - C_j dV/dP_i) / V
//
//   n dA = (F_s x F_t) ds dt; component k of it is the sum over d of (grad F_{k+1} x grad F_{k+2})_d times component d of
//   the area element at rest, and F is one polynomial on a knot box. Its products are summed with the box's moments.
//   Since x = sum P_i N_i + outside, V and S follow from the derivatives.
//
// The surface must be closed (surface_closure.h): otherwise neither V nor its derivatives mean anything. V is within
// 1e-12 of its size where the surface is not far thinner than it is wide. For degrees (2, 2, 2) a box takes 25,000
// multiply-adds for V with dV/dP, for (3, 3, 3) 190,000; for C with its derivatives 100,000 and 820,000. With vertex
// weights V takes 2.2 times as long (weighted_volume.h), and C is integrated patch by patch (patch_integrals.h). So is
// V where there are no tables with weights, and both under turned lattices.
//
// Units    world units
// Errors   none: callers check that the surface is closed
// Threads  pure functions; patch by patch on the threads of `arena`, with the same bits for any number of them
#ifndef LATTICED_CORE_MEASURE_ENCLOSED_VOLUME_H_
#define LATTICED_CORE_MEASURE_ENCLOSED_VOLUME_H_

#include <array>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/measure/surface_moments.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

struct EnclosedVolume {
  double volume = 0;            // negative if the faces are oriented inwards
  std::vector<Vec3d> gradient;  // dV/dP, one for each control point
};
// `arena`: threads for moments that are by patches; null: the caller's alone.
[[nodiscard]] EnclosedVolume MeasureVolume(const SurfaceMoments& moments,
                                           std::span<const Vec3d> control_points,
                                           CpuArena* arena = nullptr);

struct EnclosedCentroid {
  EnclosedVolume volume;
  Vec3d centroid;
  // For each control point, [i][j] = d centroid[j] / d coordinate i.
  std::vector<std::array<Vec3d, 3>> gradient;
};
// The moments must be of kCentroid, their plan without weights and turned lattices. A volume of 0 has no centroid: it is then
// not finite.
[[nodiscard]] EnclosedCentroid MeasureCentroid(const SurfaceMoments& moments,
                                               std::span<const Vec3d> control_points);
// The same of any plan, by quadrature on patches; with weights and turned lattices the only way. Without `with_gradient`, the
// derivatives are empty. Errors: what `stop` returns.
[[nodiscard]] absl::StatusOr<EnclosedVolume> MeasureVolumeByPatches(
    const DeformPlan& plan, std::span<const Vec3d> control_points, StopCheck stop = NeverStop,
    CpuArena* arena = nullptr, bool with_gradient = true);
[[nodiscard]] absl::StatusOr<EnclosedCentroid> MeasureCentroidByPatches(
    const DeformPlan& plan, std::span<const Vec3d> control_points, StopCheck stop = NeverStop,
    CpuArena* arena = nullptr, bool with_gradient = true);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_ENCLOSED_VOLUME_H_
