// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The steps of direct_kernel.cuh: the points of a triple (direct_triple.h) of a patch.
// Barycentric coordinates of point r are those with respect to corners r, r + 1 and r + 2.
#ifndef LATTICED_CUDA_FUSED_DIRECT_POINTS_CUH_
#define LATTICED_CUDA_FUSED_DIRECT_POINTS_CUH_

#include "cuda/fused/direct_patch.cuh"
#include "cuda/fused/direct_triple.h"
#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_point.cuh"

namespace latticed::kernels {

// By component at one point: the value, then the derivatives by coordinates 2, 1 and 0.
using DirectJet = float[3][4];

// The same for all points of a triple.
struct Barycentrics {
  float of[3];

  __device__ __forceinline__ explicit Barycentrics(const DirectTriple& triple) {
    const float step = 1 / static_cast<float>(triple.segments);
#pragma unroll
    for (int i = 0; i < 3; ++i) of[i] = static_cast<float>(triple.steps[i]) * step;
  }
  __device__ __forceinline__ float Blend(float a, float b, float c) const {
    return fmaf(a, of[0], fmaf(b, of[1], c * of[2]));
  }
};

// The conormal of the r-th point.
__device__ __forceinline__ void BlendConormals(const DirectPatch& patch, const Barycentrics& b,
                                               int r, float (&conormal)[3]) {
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    conormal[i] = b.Blend(patch.corner(r).conormal[i], patch.corner((r + 1) % 3).conormal[i],
                          patch.corner((r + 2) % 3).conormal[i]);
  }
}

// The jets of three points of a box. Each coefficient is loaded once for all.
template <int D0, int D1, int D2>
__device__ __forceinline__ void EvaluateJets(const FusedLaunch& launch, uint32_t box,
                                             const float (&place)[3][3], DirectJet (&jet)[3]) {
  constexpr int kStride = CoefficientStride(D0, D1, D2);
#pragma unroll
  for (int component = 0; component < 3; ++component) {
    float c[kStride];
    LoadCoefficients<kStride>(launch, box, component, c);
#pragma unroll
    for (int r = 0; r < 3; ++r) {
      PointJet<D0, D1, D2, true>::Evaluate(c, place[r], jet[r][component]);
    }
  }
}

// For points of a triple on the rim that another box owns: calls take(owner, place, r, component, value) with the values
// of that box's polynomial, and the place in its coordinates.
template <int D0, int D1, int D2, class Take>
__device__ __forceinline__ void EvaluateByOwners(const FusedLaunch& launch,
                                                 const DirectPatch& patch,
                                                 const DirectTriple& triple, const Take& take) {
  constexpr int kStride = CoefficientStride(D0, D1, D2);
  const int k = triple.steps[1];
#pragma unroll 1
  for (int r = 0; r < 3; ++r) {
    const uint32_t owner = k == 0 ? patch.OwnerOfCorner(r) : patch.OwnerOfEdge(r);
    if (owner == patch.box()) continue;
    float from[3], to[3], place[3];
    patch.PlaceCorner(r, owner, from);
    patch.PlaceCorner(r == 2 ? 0 : r + 1, owner, to);
    PlaceOnEdge(from, to, k, launch.segments, place);
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride], value;
      LoadCoefficients<kStride>(launch, owner, component, c);
      PointJet<D0, D1, D2, false>::Evaluate(c, place, &value);
      // An index that is not a constant would move the jets from registers to memory.
#pragma unroll
      for (int q = 0; q < 3; ++q) {
        if (q == r) take(owner, place, q, component, value);
      }
    }
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_POINTS_CUH_
