// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/direct_kernel.cuh"
#include "cuda/fused/fused_launch.h"

namespace latticed::kernels {

KernelCall DirectCall(const FusedLaunch& launch) {
  const unsigned blocks =
      (launch.blocks.Count(launch.chunk_count) + kDirectWarps - 1) / kDirectWarps;
  const bool weighted = launch.plan.weights.vertices != nullptr;
  return CallByDegree(launch.tables.degree, [&]<int D0, int D1, int D2> {
    const auto kernel =
        weighted ? &DirectKernel<D0, D1, D2, true> : &DirectKernel<D0, D1, D2, false>;
    return KernelCall(kernel, Order::kDependent, blocks, kDirectThreads, 0, launch);
  });
}

}  // namespace latticed::kernels
