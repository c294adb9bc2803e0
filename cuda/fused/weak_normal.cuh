// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Replaces the normal of one point, when cancellation has taken its digits, by that of the definition.
#ifndef LATTICED_CUDA_FUSED_WEAK_NORMAL_CUH_
#define LATTICED_CUDA_FUSED_WEAK_NORMAL_CUH_

#include "core/ffd/tessellation_pattern.h"
#include "cuda/fused/fused_geometry.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {

// `lane`: that of the patch. Called after the vertex is stored.
template <bool kFloat>
__device__ __forceinline__ void ReplaceNormal(const FusedLaunch& launch, uint32_t chunk,
                                              unsigned lane, int row, int column) {
  const double over = 1.0 / launch.segments;
  const Vec3d b{(launch.segments - row - column) * over, column * over, row * over};
  const Vec3d n = DefinitionNormal(launch.plan, launch.control_points, chunk * kLanes + lane, b,
                                   launch.normals == Normals::kSmooth);
  const VertexSink<kFloat> sink(launch, chunk, lane);
  sink.StoreNormal(sink.Place(PointIndex(launch.segments, row, column)), ToFloat(n));
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEAK_NORMAL_CUH_
