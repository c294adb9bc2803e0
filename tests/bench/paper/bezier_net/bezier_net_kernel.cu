// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A block takes kNetGroup patches through the steps of bezier_net.h, one thread per sample.
#include "tests/bench/paper/comparator_kernels.h"

namespace latticed::bench {
namespace {

__global__ void __launch_bounds__(kNetGroup* kMostNet)
    NetKernel(const __grid_constant__ NetJob job) {
  // Raw bytes, because shared memory has no constructors.
  __shared__ alignas(NetGroup) unsigned char memory[sizeof(NetGroup)];
  auto& group = *reinterpret_cast<NetGroup*>(memory);
  const size_t first = size_t{blockIdx.x} * kNetGroup;
  const int step = static_cast<int>(threadIdx.x);
  NetSample(job, first, step, group);
  __syncthreads();
  NetControl(job, first, step, group);
}

}  // namespace

cudaError_t LaunchBezierNets(const NetJob& job, int m, cudaStream_t stream) {
  if (job.count == 0) return cudaSuccess;
  const auto groups = static_cast<unsigned>((job.count + kNetGroup - 1) / kNetGroup);
  NetKernel<<<groups, static_cast<unsigned>(kNetGroup * m), 0, stream>>>(job);
  return cudaGetLastError();
}

}  // namespace latticed::bench
