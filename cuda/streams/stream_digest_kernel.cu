// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A chunk's digest is two sums of 64 bits. Each adds, for every eight bytes of the chunk, a mixing function
// of these bytes and of their place (splitmix64's: Stafford's variants 13 and 4 of Murmur3's finaliser).
// The order of a sum does not matter, so all threads add to it. The host uses another digest
// (core/view/view_encoder.cc), so a chunk that was encoded on the host is encoded here once more. The lowest bit says which
// one it is (core/backend.h).
#include "cuda/streams/stream_kernels.h"
#include "cuda/streams/warp.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kThreads = 128;
constexpr uint64_t kStep = 0x9e3779b97f4a7c15;  // of splitmix64

__device__ uint64_t Mix13(uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
  x = (x ^ x >> 27) * 0x94d049bb133111eb;
  return x ^ x >> 31;
}
__device__ uint64_t Mix4(uint64_t x) {
  x = (x ^ x >> 33) * 0x62a9d9ed799705f5;
  x = (x ^ x >> 28) * 0xcb24d0a5c88c35b3;
  return x ^ x >> 32;
}

__device__ uint64_t WarpSum(uint64_t value) {
  for (unsigned step = kWarp / 2; step > 0; step /= 2) {
    value += __shfl_xor_sync(kAllLanes, value, static_cast<int>(step));
  }
  return value;
}

// Eight bytes at a multiple of 2.
__device__ uint64_t WordAt(const uint8_t* bytes) {
  const auto* parts = reinterpret_cast<const uint16_t*>(bytes);
  uint64_t word = 0;
#pragma unroll
  for (int k = 0; k < 4; ++k) word |= uint64_t{__ldg(parts + k)} << (16 * k);
  return word;
}

// The digest of `count` bytes at a multiple of 2.
__device__ StreamDigest DigestOf(const uint8_t* bytes, uint32_t count) {
  __shared__ StreamDigest sum;
  if (threadIdx.x == 0) sum = {count, count};
  __syncthreads();
  const auto* words = reinterpret_cast<const uint64_t*>(bytes);
  const bool aligned = reinterpret_cast<uintptr_t>(bytes) % sizeof(uint64_t) == 0;
  uint64_t low = 0, high = 0;
  const auto add = [&](uint32_t i, uint64_t word) {
    const uint64_t key = word + (i + uint64_t{1}) * kStep;
    low += Mix13(key);
    high += Mix4(key);
  };
#pragma unroll 4
  for (uint32_t i = threadIdx.x; i < count / 8; i += kThreads) {
    add(i, aligned ? __ldg(words + i) : WordAt(bytes + 8 * i));
  }
  if (threadIdx.x == 0 && count % 8 != 0) {
    uint64_t rest = 0;
    for (uint32_t b = 0; b < count % 8; ++b) {
      rest |= uint64_t{bytes[count / 8 * 8 + b]} << (8 * b);
    }
    add(count / 8, rest);
  }
  low = WarpSum(low);
  high = WarpSum(high);
  if (Lane() == 0) {
    atomicAdd(&sum.low, low);
    atomicAdd(&sum.high, high);
  }
  __syncthreads();
  return {sum.low | 1, sum.high};
}

__global__ void __launch_bounds__(kThreads) DigestKernel(const __grid_constant__ StreamWork work) {
  const uint32_t chunk = blockIdx.x;
  const StreamDigest found =
      DigestOf(work.Vertices(chunk), work.Points(chunk) * work.BytesPerPoint());
  if (threadIdx.x == 0) work.digests[work.count + chunk] = found;
}

}  // namespace

cudaError_t LaunchStreamDigests(const StreamWork& work, cudaStream_t stream) {
  if (work.count == 0 || work.digests == nullptr) return cudaSuccess;
  DigestKernel<<<work.count, kThreads, 0, stream>>>(work);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
