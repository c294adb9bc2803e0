// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The instance of the fused kernel that fits a launch. Instantiated by fused_facet_float.cu and its
// like, which compile side by side.
#ifndef LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_
#define LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_

#include "cuda/fused/fused_kernel.cuh"
#include "cuda/fused/fused_launch.h"

namespace latticed::kernels {

template <int D0, int D1, int D2, bool kSmooth, bool kFloat>
KernelCall InstanceCall(const FusedLaunch& launch) {
  return {&FusedKernel<D0, D1, D2, kSmooth, kFloat>,
          Order::kDependent,
          launch.blocks.Count(launch.chunk_count),
          kFusedThreads,
          FusedShared<D0 + D1 + D2, kSmooth, kFloat>::Bytes(launch.segments),
          launch};
}

template <bool kSmooth, bool kFloat>
KernelCall FusedCallByDegree(const FusedLaunch& launch) {
  const int* d = launch.tables.degree;
  switch (100 * d[0] + 10 * d[1] + d[2]) {
    case 111:
      return InstanceCall<1, 1, 1, kSmooth, kFloat>(launch);
    case 211:
      return InstanceCall<2, 1, 1, kSmooth, kFloat>(launch);
    case 221:
      return InstanceCall<2, 2, 1, kSmooth, kFloat>(launch);
    case 222:
      return InstanceCall<2, 2, 2, kSmooth, kFloat>(launch);
    case 311:
      return InstanceCall<3, 1, 1, kSmooth, kFloat>(launch);
    case 321:
      return InstanceCall<3, 2, 1, kSmooth, kFloat>(launch);
    case 322:
      return InstanceCall<3, 2, 2, kSmooth, kFloat>(launch);
    case 331:
      return InstanceCall<3, 3, 1, kSmooth, kFloat>(launch);
    case 332:
      return InstanceCall<3, 3, 2, kSmooth, kFloat>(launch);
    case 333:
      return InstanceCall<3, 3, 3, kSmooth, kFloat>(launch);
    default:
      return {};
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_LAUNCH_CUH_
