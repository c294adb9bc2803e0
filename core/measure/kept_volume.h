// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The least move of control points that restores a volume.
//            Hahmann, Bonneau, Barbier, Elber & Hagen 2012, Volume-preserving FFD for programmable graphics hardware,
//            The Visual Computer 28, doi:10.1007/s00371-011-0608-6
//
//   minimise |d|^2 so that V(P + d) = V0:    d <- g (V0 - V(P + d) + g . d) / g . g,   g = dV/dP at P + d
//
// g is zero at control points that are not free, and averaged with its mirror image. With one axis, d and g have only
// the component along it; V is then linear in d, so the first step is exact but for rounding. Control points on which a
// seam depends count as held, because their move would tear the surface.
//
// Errors   kFailedPrecondition VOLUME_NOT_KEPT
// Threads  pure functions, on the threads of `arena` (enclosed_volume.h)
#ifndef LATTICED_CORE_MEASURE_KEPT_VOLUME_H_
#define LATTICED_CORE_MEASURE_KEPT_VOLUME_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/constraints/constraints.h"
#include "core/ffd/constraints/point_freedom.h"
#include "core/ffd/outside/outside_map.h"
#include "core/measure/surface_moments.h"

namespace latticed {

class CpuArena;  // core/view/cpu_arena.h

inline constexpr double kVolumeTolerance = 1e-12;  // of the volume
inline constexpr int kMostVolumeSteps = 10;

// The volume of the mesh at rest.
[[nodiscard]] double RestVolume(const SurfaceMoments& moments, CpuArena* arena = nullptr);

// Restores kept.volume, or the rest volume, after an edit that wrote the control points `named`: moves the others that
// are free, or if these cannot restore it, all that are free. `freedom` may be null. The surface must be closed. Returns
// the number of steps. On an error, nothing has moved. The moments are those of a lattice that `outside` has continued;
// null: of the control points themselves.
[[nodiscard]] absl::StatusOr<int> KeepVolume(const SurfaceMoments& moments, const KeptVolume& kept,
                                             const PointFreedom* freedom,
                                             const std::vector<bool>& named,
                                             std::vector<Vec3d>& control_points,
                                             const OutsideMap* outside = nullptr,
                                             CpuArena* arena = nullptr);

}  // namespace latticed

#endif  // LATTICED_CORE_MEASURE_KEPT_VOLUME_H_
