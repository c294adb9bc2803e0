// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions that one file of the fused kernels defines and another calls.
#ifndef LATTICED_CUDA_FUSED_FUSED_LAUNCH_H_
#define LATTICED_CUDA_FUSED_FUSED_LAUNCH_H_

#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

// FusedCall with direct_kernel.cuh.
KernelCall DirectCall(const FusedLaunch& launch);
// FusedCall with fused_kernel.cuh, for one kind of normals and format, and for meshes with or without
// weights. The facet kernel also serves views without normals.
template <bool kSmooth, bool kFloat, bool kWeighted>
KernelCall FusedCallByDegree(const FusedLaunch& launch);
extern template KernelCall FusedCallByDegree<false, false, false>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<false, false, true>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<false, true, false>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<false, true, true>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<true, false, false>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<true, false, true>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<true, true, false>(const FusedLaunch&);
extern template KernelCall FusedCallByDegree<true, true, true>(const FusedLaunch&);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_LAUNCH_H_
