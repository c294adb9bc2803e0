// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One thread an item, in blocks of kBlockThreads.
#ifndef LATTICED_CUDA_LAUNCH_CUH_
#define LATTICED_CUDA_LAUNCH_CUH_

#include <cstddef>

#include "core/ffd/volume_point.h"
#include "cuda/kernels.h"

namespace latticed::kernels {

inline constexpr unsigned kBlockThreads = 128;

inline unsigned Blocks(size_t items) {
  return static_cast<unsigned>((items + kBlockThreads - 1) / kBlockThreads);
}

// The item of this thread; callers return where it is past the last.
__device__ inline size_t Item() { return size_t{blockIdx.x} * kBlockThreads + threadIdx.x; }

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

#endif  // LATTICED_CUDA_LAUNCH_CUH_
