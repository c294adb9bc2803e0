// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A lattice with the given control points.
#ifndef LATTICED_CUDA_PLAN_VOLUME_CUH_
#define LATTICED_CUDA_PLAN_VOLUME_CUH_

#include "core/ffd/box/volume_point.h"

namespace latticed::kernels {

// `Tables`: PlanTables or TurnedTable. `control_points`: from the first of this lattice on.
template <class Tables>
__device__ inline VolumeView Volume(const Tables& lattice, const Vec3d* control_points) {
  VolumeView volume;
  for (int axis = 0; axis < 3; ++axis) {
    volume.degree[axis] = lattice.degree[axis];
    volume.size[axis] = lattice.size[axis];
    volume.knots[axis] = lattice.knots[axis];
  }
  volume.control_points = control_points;
  return volume;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_VOLUME_CUH_
