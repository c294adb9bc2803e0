// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused_launch.h"

namespace latticed::kernels {

KernelCall FusedCall(const FusedLaunch& launch) {
  const bool floats = launch.output.format == LaneFormat::kFloat32;
  if (launch.normals == Normals::kSmooth) {
    return floats ? FusedCallByDegree<true, true>(launch) : FusedCallByDegree<true, false>(launch);
  }
  return floats ? FusedCallByDegree<false, true>(launch) : FusedCallByDegree<false, false>(launch);
}

}  // namespace latticed::kernels
