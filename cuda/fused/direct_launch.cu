// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/direct_kernel.cuh"
#include "cuda/fused/fused_launch.h"

namespace latticed::kernels {

KernelCall DirectCall(const FusedLaunch& launch) {
  const unsigned blocks =
      (launch.blocks.Count(launch.chunk_count) + kDirectWarps - 1) / kDirectWarps;
  return CallByDegree(launch.tables.degree, [&]<int D0, int D1, int D2> {
    return KernelCall(&DirectKernel<D0, D1, D2>, Order::kDependent, blocks, kDirectThreads, 0,
                      launch);
  });
}

}  // namespace latticed::kernels
