// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/gpu_kernels.h"

namespace latticed::bench {
namespace {

constexpr unsigned kFillThreads = 256;
constexpr unsigned kFillsPerThread = 4;
constexpr long long kMostGateCycles = 40'000'000;  // 20 ms at 2 GHz

// Neighbouring threads write neighbouring 16 bytes. Each thread writes four times, kFillThreads
// elements apart.
__global__ void __launch_bounds__(kFillThreads) FillKernel(float4* to, size_t count, float value) {
  const size_t first = size_t{blockIdx.x} * kFillThreads * kFillsPerThread + threadIdx.x;
#pragma unroll
  for (unsigned k = 0; k < kFillsPerThread; ++k) {
    const size_t i = first + k * kFillThreads;
    if (i < count) to[i] = make_float4(value, value, value, value);
  }
}

// Independent chains hide each other's latency. All of them enter the result.
__global__ void __launch_bounds__(kMultiplyAddThreads) MultiplyAddKernel(float factor, float* out) {
  const unsigned i = blockIdx.x * kMultiplyAddThreads + threadIdx.x;
  const float start = static_cast<float>(threadIdx.x);
  float chain[kMultiplyAddChains];
#pragma unroll
  for (int c = 0; c < kMultiplyAddChains; ++c) chain[c] = start + static_cast<float>(c);
#pragma unroll 4
  for (int round = 0; round < kMultiplyAddRounds; ++round) {
#pragma unroll
    for (int c = 0; c < kMultiplyAddChains; ++c) chain[c] = fmaf(chain[c], factor, start);
  }
  float sum = 0;
#pragma unroll
  for (int c = 0; c < kMultiplyAddChains; ++c) sum += chain[c];
  out[i] = sum;
}

__global__ void GateKernel(const volatile unsigned* flag, unsigned ticket) {
  const long long start = clock64();
  while (*flag < ticket && clock64() - start < kMostGateCycles) {
  }
}

}  // namespace

cudaError_t LaunchFill(float4* to, size_t count, float value, cudaStream_t stream) {
  constexpr size_t kPerBlock = size_t{kFillThreads} * kFillsPerThread;
  const auto blocks = static_cast<unsigned>((count + kPerBlock - 1) / kPerBlock);
  FillKernel<<<blocks, kFillThreads, 0, stream>>>(to, count, value);
  return cudaGetLastError();
}

cudaError_t LaunchMultiplyAdds(int blocks, float factor, float* out, cudaStream_t stream) {
  MultiplyAddKernel<<<static_cast<unsigned>(blocks), kMultiplyAddThreads, 0, stream>>>(factor, out);
  return cudaGetLastError();
}

cudaError_t LaunchGate(const unsigned* flag, unsigned ticket, cudaStream_t stream) {
  GateKernel<<<1, 1, 0, stream>>>(flag, ticket);
  return cudaGetLastError();
}

}  // namespace latticed::bench
