// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/limits.h"
#include "core/patches/edge_bound.h"
#include "cuda/bounds/bound_kernels.h"

namespace latticed::kernels {
namespace {

constexpr unsigned kWarp = 32, kThreads = kEdgeByteChunks * kWarp;
// Edges of a chunk that one lane takes, at most.
constexpr unsigned kLaneEdges = 3 * limits::kPatchesPerChunk / kWarp;
static_assert(kLaneEdges * kWarp == 3 * limits::kPatchesPerChunk);

// Returns whether a byte of the chunk changed. Called by one warp.
__device__ bool UpdateChunk(const EdgeBytesLaunch& launch, uint32_t chunk) {
  const uint32_t first = launch.first_edges[chunk] + threadIdx.x % kWarp;
  const uint32_t end = launch.first_edges[chunk + 1];
  uint8_t now[kLaneEdges];
  bool differs = false;
#pragma unroll
  for (uint32_t k = 0; k < kLaneEdges; ++k) {
    const uint32_t edge = first + k * kWarp;
    if (edge >= end) continue;
    now[k] = EdgeBoundByte(__uint_as_float(launch.edge_maxima[edge]), launch.unit);
    differs |= launch.bytes[edge] != now[k];
  }
  if (!__any_sync(~0u, differs)) return false;
#pragma unroll
  for (uint32_t k = 0; k < kLaneEdges; ++k) {
    const uint32_t edge = first + k * kWarp;
    if (edge >= end) continue;
    launch.bytes[edge] = now[k];
    launch.host_bytes[edge] = now[k];
  }
  return true;
}

__global__ void __launch_bounds__(kThreads)
    EdgeBytesKernel(const __grid_constant__ EdgeBytesLaunch launch) {
  __shared__ uint32_t changed;
  if (threadIdx.x == 0) changed = 0;
  __syncthreads();
  const uint32_t warp = threadIdx.x / kWarp, chunk = blockIdx.x * kEdgeByteChunks + warp;
  if (chunk < launch.chunk_count && UpdateChunk(launch, chunk) && threadIdx.x % kWarp == 0) {
    atomicOr(&changed, 1u << warp);
  }
  __syncthreads();
  if (threadIdx.x == 0) launch.host_changed[blockIdx.x] = changed;
}

}  // namespace

KernelCall EdgeBytesCall(const EdgeBytesLaunch& launch) {
  const unsigned blocks = (launch.chunk_count + kEdgeByteChunks - 1) / kEdgeByteChunks;
  return {EdgeBytesKernel, Order::kAfter, blocks, kThreads, 0, launch};
}

}  // namespace latticed::kernels
