// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which bytes leave a state, for the kernel that stores them and the kernel that packs them. A word has two bits for each of
// sixteen symbols: bit i says whether a byte leaves at symbol i, and bit 16 + i whether two do.
#ifndef LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_
#define LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_

#include <cstdint>

namespace latticed::kernels {

// `one`, `two`: by symbol, whether one byte leaves, and whether two do. Returns the word of the first sixteen of 32 symbols,
// or of the others where `half` is 1.
__device__ __forceinline__ uint32_t LeavingWord(unsigned one, unsigned two, uint32_t half) {
  return half == 0 ? (one & 0xffff) | two << 16 : one >> 16 | (two & 0xffff0000);
}
// How many bytes sixteen symbols have.
__device__ __forceinline__ uint32_t SumOfBytes(uint32_t word) {
  return static_cast<uint32_t>(__popc(word));
}
// How many bytes leave at symbol i.
__device__ __forceinline__ uint32_t BytesAt(uint32_t word, uint32_t i) {
  return (word >> i & 1) + (word >> (16 + i) & 1);
}

// How many bytes DracoStream::last_word has; its highest byte says so.
__device__ __forceinline__ uint32_t LastBytes(uint32_t last_word) {
  return last_word < 1u << 8 ? 1 : last_word < 1u << 16 ? 2 : last_word < 1u << 24 ? 3 : 4;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DRACO_DRACO_LEAVING_CUH_
