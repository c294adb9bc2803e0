// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused_launch.cuh"

namespace latticed::kernels {

template cudaError_t LaunchFusedByDegree<true, false>(const FusedLaunch&, cudaStream_t);

}  // namespace latticed::kernels
