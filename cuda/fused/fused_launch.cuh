// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Selects the instance of the fused kernel for a launch. fused_facet_float.cu and its three
// siblings instantiate this template, so that they compile in parallel.
#ifndef LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_
#define LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_

#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/fused_kernel.cuh"
#include "cuda/fused/fused_launch.h"

namespace latticed::kernels {

template <bool kSmooth, bool kFloat, bool kWeighted>
KernelCall FusedCallByDegree(const FusedLaunch& launch) {
  return CallByDegree(launch.tables.degree, [&]<int D0, int D1, int D2> {
    using Block = FusedBlock<D0, D1, D2, kSmooth, kFloat, kWeighted>;
    return KernelCall(&FusedKernel<D0, D1, D2, kSmooth, kFloat, kWeighted>, Order::kDependent,
                      launch.blocks.Count(launch.chunk_count), kFusedThreads,
                      Block::Shared::Bytes(launch.segments), launch);
  });
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_
