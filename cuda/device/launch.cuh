// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Kernels with one thread per item, in blocks of kBlockThreads.
#ifndef LATTICED_CUDA_DEVICE_LAUNCH_CUH_
#define LATTICED_CUDA_DEVICE_LAUNCH_CUH_

#include <cstddef>

namespace latticed::kernels {

inline constexpr unsigned kBlockThreads = 128;

inline unsigned Blocks(size_t items) {
  return static_cast<unsigned>((items + kBlockThreads - 1) / kBlockThreads);
}

// The item of this thread. Threads of the last block may be past the last item and must return.
__device__ inline size_t Item() { return size_t{blockIdx.x} * kBlockThreads + threadIdx.x; }

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_LAUNCH_CUH_
