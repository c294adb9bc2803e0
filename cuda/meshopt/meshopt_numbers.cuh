// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of a block of 256 vertices, and their differences: eight for each lane of a warp.
#ifndef LATTICED_CUDA_MESHOPT_MESHOPT_NUMBERS_CUH_
#define LATTICED_CUDA_MESHOPT_MESHOPT_NUMBERS_CUH_

#include <cstdint>

#include "core/codec/meshopt/meshopt_format.h"
#include "cuda/meshopt/meshopt_differences.h"
#include "cuda/streams/warp.cuh"

namespace latticed::kernels {

// Two lanes take a group, eight vertices each.
inline constexpr uint32_t kLaneVertices = meshopt_format::kBlockVertices / kWarp;
inline constexpr uint32_t kGroupLanes = meshopt_format::kGroupVertices / kLaneVertices;
static_assert(kLaneVertices == 8 && kGroupLanes == 2);

// Eight numbers of kBits bits, side by side.
template <unsigned kBits>
struct EightNumbers {
  uint32_t words[kBits / 4];
};
template <unsigned kBits>
struct NumberOf;
template <>
struct NumberOf<8> {
  using Type = uint8_t;
  using Eight = uint2;
};
template <>
struct NumberOf<16> {
  using Type = uint16_t;
  using Eight = uint4;
};

// Those from `first` on. Past the last one they repeat it.
template <unsigned kBits>
__device__ __forceinline__ EightNumbers<kBits> NumbersAt(
    const typename NumberOf<kBits>::Type* numbers, uint32_t first, uint32_t points) {
  using Eight = typename NumberOf<kBits>::Eight;
  EightNumbers<kBits> its{};
  const auto* from = reinterpret_cast<const Eight*>(numbers + first);
  if (first + kLaneVertices <= points && reinterpret_cast<uintptr_t>(from) % sizeof(Eight) == 0) {
    const Eight all = __ldg(from);
    its.words[0] = all.x;
    its.words[1] = all.y;
    if constexpr (kBits == 16) {
      its.words[2] = all.z;
      its.words[3] = all.w;
    }
    return its;
  }
#pragma unroll
  for (uint32_t k = 0; k < kLaneVertices; ++k) {
    const uint32_t number = __ldg(numbers + min(first + k, points - 1));
    its.words[k * kBits / 32] |= number << (k * kBits % 32);
  }
  return its;
}

// The differences of this lane's numbers in a block that begins at `first`.
template <unsigned kBits>
__device__ __forceinline__ EightNumbers<kBits> DifferencesAt(
    const typename NumberOf<kBits>::Type* numbers, uint32_t first, uint32_t points) {
  constexpr uint32_t kWords = kBits / 4;
  EightNumbers<kBits> its = NumbersAt<kBits>(numbers, first + Lane() * kLaneVertices, points);
  // Its highest bits are the number before; the first number of a chunk is before itself.
  uint32_t before = __shfl_up_sync(kAllLanes, its.words[kWords - 1], 1);
  if (Lane() == 0) before = uint32_t{__ldg(numbers + max(first, 1u) - 1)} << (32 - kBits);
#pragma unroll
  for (uint32_t w = 0; w < kWords; ++w) {
    const uint32_t word = its.words[w];
    its.words[w] = ZigzagDifferences<kBits>(word, __funnelshift_l(before, word, kBits));
    before = word;
  }
  return its;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_MESHOPT_MESHOPT_NUMBERS_CUH_
