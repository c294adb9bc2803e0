// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a lane combines the displacement G = F(x) - x at a point with the mesh at rest (core/ffd/weights/vertex_weights.h):
//
//   P = x + w G,   dP = dx + w dG + G dw
//
// NoWeights stands for a mesh without weights: it does nothing, and the kernels are the same as if it were not there.
// Twin of core/cpu/fused/kernel/fused_weights-inl.h.
#ifndef LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_
#define LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_

#include <type_traits>

#include "cuda/fused/fused_geometry.cuh"

namespace latticed::kernels {

struct NoWeights {
  struct Row {};

  __device__ NoWeights(const FusedLaunch&, uint32_t) {}
  template <class Blend>
  __device__ float WeightAt(int, const Blend&) const {
    return 1;
  }
  __device__ static Row RowOf(const FusedLaunch&, uint32_t, int) { return {}; }
  __device__ static float Position(Row, const float*, float, float position) { return position; }
  __device__ void Combine(Row, const float*, float, float (&)[4]) const {}
  __device__ static double CofactorBound(const FusedLaunch& launch, uint32_t box, uint32_t) {
    return launch.polynomials.cofactor_bounds[box];
  }
};

class WeightedPatch {
 public:
  // Reads only the plan.
  __device__ __forceinline__ WeightedPatch(const FusedLaunch& launch, uint32_t index) {
    const DevicePatch patch = launch.plan.patches[index];
    const WeightTables& weights = launch.plan.weights;
    const Vec3d gradient = weights.gradients[index];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      corner_[i] = static_cast<float>(weights.vertices[patch.Vertex(i)]);
      slope_[i] = static_cast<float>(Dot(gradient, weights.boxes[patch.Box()].by_coordinate[i]));
    }
  }

  // blend(a, b, c): a number at the point, from those of corner r and of the next two.
  template <class Blend>
  __device__ __forceinline__ float WeightAt(int r, const Blend& blend) const {
    return blend(corner_[r], corner_[(r + 1) % 3], corner_[(r + 2) % 3]);
  }

  // One component of the points of a box at rest.
  struct Row {
    float4 of;

    __device__ __forceinline__ float At(const float* place) const {
      return fmaf(place[0], of.y, fmaf(place[1], of.z, fmaf(place[2], of.w, of.x)));
    }
    __device__ __forceinline__ float Slope(int i) const {
      return i == 0 ? of.y : i == 1 ? of.z : of.w;
    }
  };
  __device__ __forceinline__ static Row RowOf(const FusedLaunch& launch, uint32_t box,
                                              int component) {
    return {reinterpret_cast<const float4*>(launch.polynomials.rest)[box * 3 + component]};
  }
  // A component of P. `place`: box-local.
  __device__ __forceinline__ static float Position(Row row, const float* place, float weight,
                                                   float displacement) {
    return fmaf(weight, displacement, row.At(place));
  }
  // Turns a component of the jet of G (fused_point.cuh) into that of P.
  __device__ __forceinline__ void Combine(Row row, const float* place, float weight,
                                          float (&jet)[4]) const {
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      jet[3 - i] = fmaf(weight, jet[3 - i], fmaf(jet[0], slope_[i], row.Slope(i)));
    }
    jet[0] = Position(row, place, weight, jet[0]);
  }
  __device__ static double CofactorBound(const FusedLaunch& launch, uint32_t box, uint32_t index) {
    return WeightedCofactorBound(launch, box, Norm(launch.plan.weights.gradients[index]));
  }

 private:
  float corner_[3];  // weights
  float slope_[3];   // of the weight, by box-local coordinate
};

template <bool kWeighted>
using PatchWeights = std::conditional_t<kWeighted, WeightedPatch, NoWeights>;

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_
