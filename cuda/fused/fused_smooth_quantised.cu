// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/fused_launch.cuh"

namespace latticed::kernels {

template KernelCall FusedCallByDegree<true, false, false>(const FusedLaunch&);
template KernelCall FusedCallByDegree<true, false, true>(const FusedLaunch&);

}  // namespace latticed::kernels
