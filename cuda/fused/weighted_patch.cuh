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

#include "cuda/fused/fused_geometry.cuh"

namespace latticed::kernels {

struct NoWeights {
  struct Rest {};

  __device__ NoWeights(const FusedLaunch&, uint32_t) {}
  template <class Blend>
  __device__ Rest RestAt(int, const Blend&) const {
    return {};
  }
  __device__ float Position(const Rest&, int, float position) const { return position; }
  __device__ void Combine(const Rest&, float (&)[3][4]) const {}
  __device__ double CofactorBound(const FusedLaunch& launch, uint32_t box) const {
    return launch.polynomials.cofactor_bounds[box];
  }
};

class WeightedPatch {
 public:
  // Of a point, in the units of the output.
  struct Rest {
    float at[3], weight;
  };

  // Reads only the plan.
  __device__ __forceinline__ WeightedPatch(const FusedLaunch& launch, uint32_t index) {
    const DevicePatch patch = launch.plan.patches[index];
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      const uint32_t v = patch.Vertex(c);
      const Vec3f at = ToFloat(RestPoint(launch, launch.plan.vertices[v].world));
      corner_[c] = {{at.x, at.y, at.z}, static_cast<float>(launch.plan.weights.vertices[v])};
    }
    const Vec3d gradient = launch.plan.weights.gradients[index];
    steepness_ = Norm(gradient);
    SetSlopes(launch, patch.Box(), gradient);
  }

  // blend(a, b, c): a number at the point, from those of corner r and of the next two.
  template <class Blend>
  __device__ __forceinline__ Rest RestAt(int r, const Blend& blend) const {
    const Rest &a = corner_[r], &b = corner_[(r + 1) % 3], &c = corner_[(r + 2) % 3];
    return {{blend(a.at[0], b.at[0], c.at[0]), blend(a.at[1], b.at[1], c.at[1]),
             blend(a.at[2], b.at[2], c.at[2])},
            blend(a.weight, b.weight, c.weight)};
  }
  __device__ __forceinline__ float Position(const Rest& rest, int component,
                                            float displacement) const {
    return fmaf(rest.weight, displacement, rest.at[component]);
  }
  // Turns the jet of G (fused_point.cuh) into that of P.
  __device__ __forceinline__ void Combine(const Rest& rest, float (&jet)[3][4]) const {
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float* const its = jet[component];
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        const float slope = fmaf(its[0], slope_[i], by_coordinate_[i][component]);
        its[3 - i] = fmaf(rest.weight, its[3 - i], slope);
      }
      its[0] = Position(rest, component, its[0]);
    }
  }
  __device__ double CofactorBound(const FusedLaunch& launch, uint32_t box) const {
    return WeightedCofactorBound(launch, box, steepness_);
  }

 private:
  __device__ __forceinline__ void SetSlopes(const FusedLaunch& launch, uint32_t box,
                                            Vec3d gradient) {
    const Vec3d* row = launch.tables.boxes[box].gradient;
    const Vec3d cofactor[3] = {Cross(row[1], row[2]), Cross(row[2], row[0]), Cross(row[0], row[1])};
    const double over = 1 / Dot(row[0], cofactor[0]);
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const Vec3d world = over * cofactor[i];  // by coordinate i
      const Vec3f f = ToFloat(launch.polynomials.scale * world);
      slope_[i] = static_cast<float>(Dot(gradient, world));
      by_coordinate_[i][0] = f.x, by_coordinate_[i][1] = f.y, by_coordinate_[i][2] = f.z;
    }
  }

  Rest corner_[3];
  double steepness_;           // |grad w| in the world
  float by_coordinate_[3][3];  // of the point at rest
  float slope_[3];             // of the weight
};

template <bool kWeighted>
using PatchWeights = std::conditional_t<kWeighted, WeightedPatch, NoWeights>;

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEIGHTED_PATCH_CUH_
