// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The instance of the fused kernel that fits a launch. Instantiated by fused_facet_float.cu and its
// like, which compile side by side.
#ifndef LATTICED_CUDA_FUSED_LAUNCH_CUH_
#define LATTICED_CUDA_FUSED_LAUNCH_CUH_

#include "cuda/fused_kernel.cuh"
#include "cuda/fused_launch.h"

namespace latticed::kernels {

template <int D0, int D1, int D2, bool kSmooth, bool kFloat>
cudaError_t LaunchInstance(const FusedLaunch& launch, cudaStream_t stream) {
  const size_t bytes = FusedShared<D0 + D1 + D2, kSmooth, kFloat>::Bytes(launch.segments);
  const auto kernel = &FusedKernel<D0, D1, D2, kSmooth, kFloat>;
  if (const cudaError_t error = cudaFuncSetAttribute(
          kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes));
      error != cudaSuccess) {
    return error;
  }
  return LaunchDependent<FusedLaunch>(kernel, launch.chunk_count, kFusedThreads, bytes, stream,
                                      launch);
}

template <bool kSmooth, bool kFloat>
cudaError_t LaunchFusedByDegree(const FusedLaunch& launch, cudaStream_t stream) {
  const int* d = launch.tables.degree;
  switch (100 * d[0] + 10 * d[1] + d[2]) {
    case 111:
      return LaunchInstance<1, 1, 1, kSmooth, kFloat>(launch, stream);
    case 211:
      return LaunchInstance<2, 1, 1, kSmooth, kFloat>(launch, stream);
    case 221:
      return LaunchInstance<2, 2, 1, kSmooth, kFloat>(launch, stream);
    case 222:
      return LaunchInstance<2, 2, 2, kSmooth, kFloat>(launch, stream);
    case 311:
      return LaunchInstance<3, 1, 1, kSmooth, kFloat>(launch, stream);
    case 321:
      return LaunchInstance<3, 2, 1, kSmooth, kFloat>(launch, stream);
    case 322:
      return LaunchInstance<3, 2, 2, kSmooth, kFloat>(launch, stream);
    case 331:
      return LaunchInstance<3, 3, 1, kSmooth, kFloat>(launch, stream);
    case 332:
      return LaunchInstance<3, 3, 2, kSmooth, kFloat>(launch, stream);
    case 333:
      return LaunchInstance<3, 3, 3, kSmooth, kFloat>(launch, stream);
    default:
      return cudaErrorInvalidValue;
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_LAUNCH_CUH_
