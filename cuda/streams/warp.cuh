// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums and masks of the lanes of a warp.
#ifndef LATTICED_CUDA_STREAMS_WARP_CUH_
#define LATTICED_CUDA_STREAMS_WARP_CUH_

#include <cstdint>

namespace latticed::kernels {

inline constexpr unsigned kWarp = 32, kAllLanes = 0xffffffffu;

__device__ __forceinline__ unsigned Lane() { return threadIdx.x % kWarp; }
__device__ __forceinline__ unsigned LanesBelow() { return (1u << Lane()) - 1; }

// The sum of the values of this lane and of all lower lanes.
__device__ __forceinline__ uint32_t SumUpTo(uint32_t value) {
  for (unsigned step = 1; step < kWarp; step *= 2) {
    const uint32_t below = __shfl_up_sync(kAllLanes, value, step);
    if (Lane() >= step) value += below;
  }
  return value;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_STREAMS_WARP_CUH_
