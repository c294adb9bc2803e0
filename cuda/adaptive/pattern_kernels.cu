// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From bounds to the levels of edges, the patterns of patches and the places of their points. Twin of
// core/cpu/adaptive/level_table.h, but it looks at all patches each time.
#include <cub/device/device_scan.cuh>
#include <limits>

#include "core/adaptive/certificate.h"
#include "core/adaptive/curvature_slack.h"
#include "core/adaptive/edge_levels.h"
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/device/launch.cuh"

namespace latticed::kernels {
namespace {

constexpr float kInfiniteError = std::numeric_limits<float>::infinity();

// False for infinity and NaN.
__device__ __forceinline__ bool IsFiniteNumber(float x) { return fabsf(x) < kInfiniteError; }

__global__ void __launch_bounds__(kBlockThreads)
    EdgeMaximaKernel(const __grid_constant__ AdaptiveLaunch launch) {
  const size_t patch = Item();
  if (patch >= launch.fused.patch_count) return;
#pragma unroll
  for (int e = 0; e < 3; ++e) {
    const uint32_t bits = __float_as_uint(launch.state.edge_bounds[3 * patch + e]);
    if (bits != 0) atomicMax(launch.state.edge_maxima + launch.tables.edges[3 * patch + e], bits);
  }
}

__global__ void __launch_bounds__(kBlockThreads)
    TakeSharedKernel(const __grid_constant__ SharedMaxima shared) {
  const size_t i = Item();
  if (i < shared.count) {
    shared.bounds[i] = __uint_as_float(shared.edge_maxima[shared.edges[i]]);
  }
}

__global__ void __launch_bounds__(kBlockThreads)
    RaiseSharedKernel(const __grid_constant__ SharedMaxima shared) {
  const size_t i = Item();
  if (i < shared.count) {
    shared.edge_maxima[shared.edges[i]] = __float_as_uint(shared.bounds[i]);
  }
}

// PatternError of core/adaptive/certificate.h.
__device__ float ErrorOf(const AdaptiveTables& tables, const PatternHead& head,
                         const CurvatureBounds<float>& bounds) {
  float largest = 0;
  for (unsigned k = 0; k < head.triangles; ++k) {
    const PatternTriangle& triangle = tables.triangles[head.first_triangle + k];
    largest = fmaxf(largest, LinearError(SideCurvature(triangle.side[0], bounds),
                                         SideCurvature(triangle.side[1], bounds),
                                         SideCurvature(triangle.side[2], bounds)));
  }
  return static_cast<float>(kBoundFactor) * largest;
}

__device__ CurvatureBounds<float> LoadBounds(const AdaptiveState& state, size_t patch) {
  CurvatureBounds<float> bounds;
#pragma unroll
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = state.edge_bounds[3 * patch + e];
    bounds.mixed[e] = state.mixed_bounds[3 * patch + e];
  }
  return bounds;
}

struct PatternChoice {
  uint16_t code;
  uint32_t points;
  float error;
};
__device__ PatternChoice Choose(const AdaptiveLaunch& launch, size_t patch) {
  const CurvatureBounds<float> bounds = LoadBounds(launch.state, patch);
  PatternKey key;
  for (int e = 0; e < 3; ++e) {
    const uint32_t bits = launch.state.edge_maxima[launch.tables.edges[3 * patch + e]];
    key.levels[e] = EdgeLevel(__uint_as_float(bits), launch.tolerance);
  }
  const uint16_t dense = key.Code();
  key.sparse = true;
  const uint16_t sparse = key.Code();
  const PatternHead head = launch.tables.heads[dense], sparser = launch.tables.heads[sparse];
  PatternChoice choice{dense, 0, 0};
  bool chosen = false;
  if (sparser.points < head.points) {
    choice = {sparse, sparser.points, ErrorOf(launch.tables, sparser, bounds)};
    chosen = choice.error <= launch.tolerance;
  }
  if (!chosen) choice = {dense, head.points, ErrorOf(launch.tables, head, bounds)};
  // A maximum may pass over a NaN.
  float sum = 0;
  for (int e = 0; e < 3; ++e) sum += bounds.edge[e] + bounds.mixed[e];
  if (!IsFiniteNumber(sum)) choice.error = kInfiniteError;
  return choice;
}

// The sum of the values of this lane and of all lower lanes.
__device__ __forceinline__ uint32_t SumUpTo(uint32_t value, uint32_t lane) {
#pragma unroll
  for (unsigned step = 1; step < kChunkPatches; step *= 2) {
    const uint32_t below = __shfl_up_sync(~0u, value, step);
    if (lane >= step) value += below;
  }
  return value;
}

// A warp has the patches of one chunk.
__global__ void __launch_bounds__(kBlockThreads)
    PatternsKernel(const __grid_constant__ AdaptiveLaunch launch) {
  static_assert(kChunkPatches == 32);
  const size_t patch = Item(), chunk = patch / kChunkPatches;
  const auto lane = static_cast<uint32_t>(patch % kChunkPatches);
  if (chunk >= launch.plan_chunks) return;
  PatternChoice choice{0, 0, 0};
  const bool exists = patch < launch.fused.patch_count;
  if (exists) choice = Choose(launch, patch);
  launch.state.codes[patch] = choice.code;
  const uint32_t points = SumUpTo(choice.points, lane);
  if (exists) launch.state.first_points[patch] = static_cast<uint16_t>(points - choice.points);
  if (lane == kChunkPatches - 1) launch.state.chunk_first[chunk] = points;
  // One atomic a warp: all raise the same number. Errors are not negative.
  const uint32_t bits = __float_as_uint(choice.error);
  if (bits == __reduce_max_sync(~0u, bits)) atomicMax(launch.state.largest_error, bits);
}

}  // namespace

KernelCall EdgeMaximaCall(const AdaptiveLaunch& launch) {
  return {
      EdgeMaximaKernel, Order::kAfter, Blocks(launch.fused.patch_count), kBlockThreads, 0, launch};
}

KernelCall TakeSharedCall(const SharedMaxima& shared) {
  return {TakeSharedKernel, Order::kAfter, Blocks(shared.count), kBlockThreads, 0, shared};
}

KernelCall RaiseSharedCall(const SharedMaxima& shared) {
  return {RaiseSharedKernel, Order::kAfter, Blocks(shared.count), kBlockThreads, 0, shared};
}

KernelCall PatternsCall(const AdaptiveLaunch& launch) {
  const unsigned blocks = Blocks(size_t{launch.plan_chunks} * kChunkPatches);
  return {PatternsKernel, Order::kAfter, blocks, kBlockThreads, 0, launch};
}

cudaError_t ScanBytes(uint32_t plan_chunks, size_t& bytes) {
  uint64_t* const none = nullptr;
  return cub::DeviceScan::ExclusiveSum(nullptr, bytes, none, none,
                                       static_cast<int>(plan_chunks + 1));
}

cudaError_t LaunchScan(const AdaptiveLaunch& launch, void* scratch, size_t bytes,
                       cudaStream_t stream) {
  uint64_t* const sums = launch.state.chunk_first;
  return cub::DeviceScan::ExclusiveSum(scratch, bytes, sums, sums,
                                       static_cast<int>(launch.plan_chunks + 1), stream);
}

}  // namespace latticed::kernels
