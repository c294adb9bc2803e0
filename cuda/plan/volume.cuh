// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattice of a plan with the given control points.
#ifndef LATTICED_CUDA_PLAN_VOLUME_CUH_
#define LATTICED_CUDA_PLAN_VOLUME_CUH_

#include "core/ffd/box/volume_point.h"
#include "cuda/plan/plan_tables.h"

namespace latticed::kernels {

__device__ inline VolumeView Volume(const PlanTables& plan, const Vec3d* control_points) {
  VolumeView volume;
  for (int axis = 0; axis < 3; ++axis) {
    volume.degree[axis] = plan.degree[axis];
    volume.size[axis] = plan.size[axis];
    volume.knots[axis] = plan.knots[axis];
  }
  volume.control_points = control_points;
  return volume;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_VOLUME_CUH_
