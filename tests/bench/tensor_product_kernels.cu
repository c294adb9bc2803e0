// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes kTensorGroup patches through the steps of tensor_product.h in shared memory.
#include "tests/bench/tensor_product_launch.h"

namespace latticed::bench {
namespace {

constexpr int kControlThreads = kTensorControlSteps;  // a sample each
constexpr int kTessellationThreads = 256;

unsigned Groups(const TensorJob& job) {
  return static_cast<unsigned>((job.count + kTensorGroup - 1) / kTensorGroup);
}

__global__ void __launch_bounds__(kControlThreads)
    ControlKernel(const __grid_constant__ TensorJob job) {
  // As bytes: shared memory has no constructors.
  __shared__ alignas(TensorControlGroup) unsigned char memory[sizeof(TensorControlGroup)];
  auto& group = *reinterpret_cast<TensorControlGroup*>(memory);
  const size_t first = size_t{blockIdx.x} * kTensorGroup;
  const int step = static_cast<int>(threadIdx.x);
  ControlSample(job, first, step, group);
  __syncthreads();
  ControlRelative(job, first, step, group);
  __syncthreads();
  ControlHalf(job, first, step, group);
  __syncthreads();
  ControlWhole(job, first, step, group);
}

__global__ void __launch_bounds__(kTessellationThreads)
    TessellationKernel(const __grid_constant__ TensorJob job) {
  extern __shared__ float shared[];
  auto& group = *reinterpret_cast<TensorTessellationGroup*>(shared);
  const size_t first = size_t{blockIdx.x} * kTensorGroup;
  const int begin = static_cast<int>(threadIdx.x);
  for (int i = begin; i < kTensorLoadSteps; i += kTessellationThreads) {
    LoadControl(job, first, i, group);
  }
  __syncthreads();
  for (int i = begin; i < TensorRowSteps(job.segments); i += kTessellationThreads) {
    CollapseRow(job, i, group);
  }
  __syncthreads();
  const int points = kTensorGroup * PointsPerPatch(job.segments);
  for (int i = begin; i < points; i += kTessellationThreads) {
    TessellationPoint(job, first, i, group);
  }
}

}  // namespace

cudaError_t LaunchTensorControl(const TensorJob& job, cudaStream_t stream) {
  if (job.count == 0) return cudaSuccess;
  ControlKernel<<<Groups(job), kControlThreads, 0, stream>>>(job);
  return cudaGetLastError();
}

cudaError_t LaunchTensorTessellation(const TensorJob& job, cudaStream_t stream) {
  if (job.count == 0) return cudaSuccess;
  // The rows of fewer segments are fewer: under 48 KB at all of them.
  const size_t rows = static_cast<size_t>(kTensorGroup) * static_cast<size_t>(job.segments + 1);
  const size_t bytes = offsetof(TensorTessellationGroup, rows) + rows * sizeof(TensorRow);
  TessellationKernel<<<Groups(job), kTessellationThreads, bytes, stream>>>(job);
  return cudaGetLastError();
}

}  // namespace latticed::bench
