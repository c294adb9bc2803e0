// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused_launch.h"

namespace latticed::kernels {

cudaError_t LaunchFused(const FusedLaunch& launch, cudaStream_t stream) {
  if (launch.chunk_count == 0) return cudaSuccess;
  const bool floats = launch.output.format == LaneFormat::kFloat32;
  if (launch.normals == Normals::kSmooth) {
    return floats ? LaunchFusedByDegree<true, true>(launch, stream)
                  : LaunchFusedByDegree<true, false>(launch, stream);
  }
  return floats ? LaunchFusedByDegree<false, true>(launch, stream)
                : LaunchFusedByDegree<false, false>(launch, stream);
}

}  // namespace latticed::kernels
