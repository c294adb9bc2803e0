// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The volume of a surface with vertex weights, and its derivatives, by the tables of a box (surface_moments.h). The cost
// does not depend on the number of patches.
//
//   P = x + w G with G = F - x is a polynomial of the box's coordinates l and of w, in which a patch is a flat triangle:
//     n dA    = sum over d of (P_{d+1} x P_{d+2}) dA_(d+1, d+2) + sum over a of (P_a x G) dA_(a, w)
//     P_a     = x_a + w G_a, the derivative by l_a; x_a does not depend on l
//     dV/dP_i = integral w N_i n dA
//   With t w in place of w, V goes from the volume at rest to V, and dV/dt = integral w G . n dA. So
//     V = volume at rest + sum over j of 1 / (j + 1) times the terms of integral w G . n dA of which n has degree j in G.
//
// Units    world units
// Errors   none: the surface is closed, and the moments have weights
// Threads  pure function
#ifndef LATTICED_CORE_MEASURE_WEIGHTED_VOLUME_H_
#define LATTICED_CORE_MEASURE_WEIGHTED_VOLUME_H_

#include <span>

#include "core/measure/enclosed_volume.h"

namespace latticed {

[[nodiscard]] EnclosedVolume MeasureWeightedVolume(const SurfaceMoments& moments,
                                                   std::span<const Vec3d> control_points);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_WEIGHTED_VOLUME_H_
