// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts the bytes that leave a state, for the kernel that stores them and the kernel that packs them.
#ifndef LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_
#define LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_

#include <cstdint>

namespace latticed::kernels {

// How many bytes sixteen symbols have: the sum of sixteen numbers of two bits.
__device__ __forceinline__ uint32_t SumOfBytes(uint32_t leaving_bytes) {
  return static_cast<uint32_t>(__popc(leaving_bytes & 0x55555555) +
                               2 * __popc(leaving_bytes & 0xaaaaaaaa));
}

// How many bytes DracoStream::last_word has; its highest byte says so.
__device__ __forceinline__ uint32_t LastBytes(uint32_t last_word) {
  return last_word < 1u << 8 ? 1 : last_word < 1u << 16 ? 2 : last_word < 1u << 24 ? 3 : 4;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_
