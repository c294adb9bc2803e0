// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/fused_launch.cuh"

namespace latticed::kernels {

template KernelCall FusedCallByDegree<false, true, false>(const FusedLaunch&);
template KernelCall FusedCallByDegree<false, true, true>(const FusedLaunch&);

}  // namespace latticed::kernels
