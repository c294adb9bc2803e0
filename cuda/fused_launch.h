// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the four files of fused kernels define between them.
#ifndef LATTICED_CUDA_FUSED_LAUNCH_H_
#define LATTICED_CUDA_FUSED_LAUNCH_H_

#include "cuda/fused_kernels.h"

namespace latticed::kernels {

// As LaunchFused, for one kind of normals and format; without normals the facet kernel serves.
template <bool kSmooth, bool kFloat>
cudaError_t LaunchFusedByDegree(const FusedLaunch& launch, cudaStream_t stream);
extern template cudaError_t LaunchFusedByDegree<false, false>(const FusedLaunch&, cudaStream_t);
extern template cudaError_t LaunchFusedByDegree<false, true>(const FusedLaunch&, cudaStream_t);
extern template cudaError_t LaunchFusedByDegree<true, false>(const FusedLaunch&, cudaStream_t);
extern template cudaError_t LaunchFusedByDegree<true, true>(const FusedLaunch&, cudaStream_t);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_LAUNCH_H_
