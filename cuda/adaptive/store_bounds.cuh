// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the bounds of a patch go.
#ifndef LATTICED_CUDA_ADAPTIVE_STORE_BOUNDS_CUH_
#define LATTICED_CUDA_ADAPTIVE_STORE_BOUNDS_CUH_

#include "cuda/adaptive/adaptive_kernels.h"

namespace latticed::kernels {

__device__ __forceinline__ void StoreBounds(const AdaptiveState& state, size_t patch,
                                            const CurvatureBounds<float>& bounds) {
#pragma unroll
  for (int e = 0; e < 3; ++e) state.edge_bounds[3 * patch + e] = bounds.edge[e];
  if (state.mixed_bounds == nullptr) return;
#pragma unroll
  for (int e = 0; e < 3; ++e) state.mixed_bounds[3 * patch + e] = bounds.mixed[e];
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_ADAPTIVE_STORE_BOUNDS_CUH_
