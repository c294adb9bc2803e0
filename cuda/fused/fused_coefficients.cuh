// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How kernels read the polynomial of a box.
#ifndef LATTICED_CUDA_FUSED_FUSED_COEFFICIENTS_CUH_
#define LATTICED_CUDA_FUSED_FUSED_COEFFICIENTS_CUH_

#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

// Loads one component of the polynomial of `box`.
template <int kStride>
__device__ __forceinline__ void LoadCoefficients(const FusedLaunch& launch, uint32_t box,
                                                 int component, float* c) {
  const size_t row = size_t{box} * 3 + static_cast<unsigned>(component);
  const auto* from = reinterpret_cast<const float4*>(launch.polynomials.coefficients +
                                                     row * static_cast<size_t>(kStride));
#pragma unroll
  for (int k = 0; k < kStride / 4; ++k) {
    const float4 v = from[k];
    c[4 * k] = v.x, c[4 * k + 1] = v.y, c[4 * k + 2] = v.z, c[4 * k + 3] = v.w;
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_COEFFICIENTS_CUH_
