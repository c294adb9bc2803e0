// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused_launch.h"

namespace latticed::kernels {

cudaError_t LaunchFused(const FusedLaunch& launch, cudaStream_t stream) {
  if (launch.chunk_count == 0) return cudaSuccess;
  return launch.normals == Normals::kSmooth ? LaunchFusedByDegree<true>(launch, stream)
                                            : LaunchFusedByDegree<false>(launch, stream);
}

}  // namespace latticed::kernels
