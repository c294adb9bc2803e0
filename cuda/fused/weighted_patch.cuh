// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a lane of the weighted kernel knows of its patch beside DirectPatch: the mesh at rest and its weights, in the units of the
// output, by the coordinates of the patch's box.
#ifndef LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_
#define LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_

#include "cuda/fused/direct_patch.cuh"
#include "cuda/fused/weighted_launch.h"

namespace latticed::kernels {

// Numbers of a point at rest: x, y, z and the weight.
inline constexpr int kRestNumbers = 4, kWeight = 3;

class WeightedPatch {
 public:
  // Reads only the plan.
  __device__ __forceinline__ WeightedPatch(const WeightedLaunch& launch, uint32_t index) {
    const FusedLaunch& fused = launch.fused;
    const DevicePatch patch = fused.plan.patches[index];
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      const uint32_t v = patch.Vertex(c);
      const Vec3d at =
          fused.polynomials.scale * fused.plan.vertices[v].world + fused.polynomials.offset;
      corner_[c][0] = static_cast<float>(at.x);
      corner_[c][1] = static_cast<float>(at.y);
      corner_[c][2] = static_cast<float>(at.z);
      corner_[c][kWeight] = static_cast<float>(launch.weights.vertices[v]);
    }
    SetSlopes(fused, patch.Box(), launch.weights.gradients[index]);
  }

  __device__ const float* corner(int c) const { return corner_[c]; }

  // Combines the jet of F at a point with the mesh at rest. `at`: the point at rest; `jet`: of F, then of the result.
  //
  //   x + w (F - x),   dx + w (dF - dx) + (F - x) dw
  //
  // error[i]: how much rounding may have changed (F - x) dw, by coordinate i.
  __device__ __forceinline__ void Combine(const float* at, float (&jet)[3][4],
                                          float (&error)[3]) const {
    const float w = at[kWeight];
    float reach = 0;
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float* const its = jet[component];
      const float offset = its[0] - at[component];
      reach = fmaxf(reach, fmaxf(fabsf(its[0]), fabsf(at[component])));
      its[0] = fmaf(w, offset, at[component]);
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        const float rest = by_coordinate_[i][component];
        its[3 - i] = fmaf(offset, slope_[i], fmaf(w, its[3 - i] - rest, rest));
      }
    }
#pragma unroll
    for (int i = 0; i < 3; ++i) error[i] = kRounding * reach * fabsf(slope_[i]);
  }

 private:
  // Twice the rounding of a float.
  static constexpr float kRounding = 0x1p-22f;

  __device__ __forceinline__ void SetSlopes(const FusedLaunch& fused, uint32_t box,
                                            Vec3d gradient) {
    const Vec3d* row = fused.tables.boxes[box].gradient;
    const Vec3d cofactor[3] = {Cross(row[1], row[2]), Cross(row[2], row[0]), Cross(row[0], row[1])};
    const double over = 1 / Dot(row[0], cofactor[0]);
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const Vec3d world = over * cofactor[i];  // by coordinate i
      slope_[i] = static_cast<float>(Dot(gradient, world));
      by_coordinate_[i][0] = static_cast<float>(fused.polynomials.scale * world.x);
      by_coordinate_[i][1] = static_cast<float>(fused.polynomials.scale * world.y);
      by_coordinate_[i][2] = static_cast<float>(fused.polynomials.scale * world.z);
    }
  }

  float corner_[3][kRestNumbers];
  float by_coordinate_[3][3];  // of the point at rest
  float slope_[3];             // of the weight
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_
