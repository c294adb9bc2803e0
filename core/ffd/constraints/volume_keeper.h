// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an edit asks to restore the enclosed volume. A lattice knows no surface, so the plan's owner provides it
// (core/measure/kept_volume.h).
//
// Threads  those of the implementation
#ifndef LATTICED_CORE_FFD_CONSTRAINTS_VOLUME_KEEPER_H_
#define LATTICED_CORE_FFD_CONSTRAINTS_VOLUME_KEEPER_H_

#include <vector>

#include "absl/status/status.h"
#include "core/ffd/constraints/constraints.h"
#include "core/ffd/constraints/point_freedom.h"

namespace latticed {

class VolumeKeeper {
 public:
  virtual ~VolumeKeeper() = default;

  // Whether the surface under the control points, at the scene's strength, has a volume to be kept. kFailedPrecondition
  // OPEN_SURFACE.
  [[nodiscard]] virtual absl::Status CheckEncloses(const std::vector<Vec3d>& control_points,
                                                   double strength) const = 0;
  // Restores the volume after an edit wrote the control points `named`: moves the others that are free, or where these
  // cannot restore it, the named ones too. `freedom` may be null: all are free. Errors: kFailedPrecondition
  // OPEN_SURFACE, VOLUME_NOT_KEPT; kResourceExhausted.
  [[nodiscard]] virtual absl::Status Keep(const KeptVolume& kept, const PointFreedom* freedom,
                                          const std::vector<bool>& named, double strength,
                                          std::vector<Vec3d>& control_points) const = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_CONSTRAINTS_VOLUME_KEEPER_H_
