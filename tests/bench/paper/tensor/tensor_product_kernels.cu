// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes kTensorGroup surfaces through the steps of tensor_product.h in shared memory.
#include "tests/bench/paper/comparator_kernels.h"

namespace latticed::bench {
namespace {

constexpr int kControlThreads = kTensorControlSteps;  // one sample per thread
// A group has about 80 lines of three steps and 340 points: two and three rounds, nearly full.
constexpr int kTessellationThreads = 128;

using Control = float[kTensorGroup][3][kTensorNet];

unsigned Groups(const TensorJob& job) {
  return static_cast<unsigned>((job.count + kTensorGroup - 1) / kTensorGroup);
}

__global__ void __launch_bounds__(kControlThreads)
    ControlKernel(const __grid_constant__ TensorJob job) {
  // Raw bytes, because shared memory has no constructors.
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
  extern __shared__ TensorCurve curves[];
  __shared__ Control control;
  const TensorTessellationGroup group{control, curves};
  const size_t first = size_t{blockIdx.x} * kTensorGroup;
  const int begin = static_cast<int>(threadIdx.x);
  for (int i = begin; i < kTensorLoadSteps; i += kTessellationThreads) {
    LoadControl(job, first, i, group);
  }
  __syncthreads();
  const int collapses = 3 * GroupLines(job, first);
  for (int i = begin; i < collapses; i += kTessellationThreads) CollapseLine(job, first, i, group);
  __syncthreads();
  const int points = GroupPoints(job, first);
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

cudaError_t LaunchTensorTessellation(const TensorJob& job, size_t most_lines, cudaStream_t stream) {
  if (job.count == 0) return cudaSuccess;
  const size_t bytes = most_lines * sizeof(TensorCurve);
  TessellationKernel<<<Groups(job), kTessellationThreads, bytes, stream>>>(job);
  return cudaGetLastError();
}

}  // namespace latticed::bench
