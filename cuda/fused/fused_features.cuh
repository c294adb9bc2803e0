// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates the positions on the corners and edges of a chunk, each once, from the polynomial of the box
// that owns it. So both sides of an edge get the same bits, also across two chunks.
#ifndef LATTICED_CUDA_FUSED_FUSED_FEATURES_CUH_
#define LATTICED_CUDA_FUSED_FUSED_FEATURES_CUH_

#include <type_traits>

#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_edge.cuh"
#include "cuda/fused/fused_point.cuh"
#include "cuda/fused/fused_shared.cuh"

namespace latticed::kernels {

// Warps 0 and 1 evaluate edges, and one of them also corners; warp 2 computes the patches' frames.
constexpr int kEdgeWarps = 2, kFrameWarp = 2;

template <int D0, int D1, int D2, bool kSmooth, bool kFloat, bool kWeighted>
class FeatureKernel {
  static constexpr int N = D0 + D1 + D2, kStride = CoefficientStride(D0, D1, D2);
  using Shared = FusedShared<N + (kWeighted ? 1 : 0), kSmooth, kFloat, kWeighted>;
  // Measured: the other warp makes float32 take 1 % longer and quantised vertices 3 %.
  static constexpr int kCornerWarp = kFloat ? 0 : 1;

 public:
  __device__ FeatureKernel(const FusedLaunch& launch, uint32_t chunk)
      : launch_(launch), sink_(launch, chunk, 0), first_patch_(chunk * kLanes) {}

  // Copies to shared memory what all warps read, and finds the first use of each corner and edge: one
  // thread a use, whose slot is the number of the warp. The caller synchronises the block after it, and
  // again after Vertices.
  __device__ __forceinline__ void Begin(const FeatureUses& uses, const DevicePatch& patch, int warp,
                                        unsigned lane) {
    if (warp == 0) Shared::Patch(lane) = patch;
    if (warp == 1) Shared::Uses(lane) = uses;
    const auto use = static_cast<uint8_t>(lane | static_cast<unsigned>(warp) << 5);
    const bool there = first_patch_ + lane < launch_.patch_count;
    if (there && uses.IsFirstOfEdge(warp)) Shared::EdgeUse(uses.Edge(warp)) = use;
    if (there && uses.IsFirstOfCorner(warp)) Shared::CornerUse(uses.Corner(warp)) = use;
    const auto most = [](unsigned a, unsigned b, unsigned c) {
      return __reduce_max_sync(~0u, max(a, max(b, c)));
    };
    corners_ = most(uses.Corner(0), uses.Corner(1), uses.Corner(2)) + 1;
    edges_ = most(uses.Edge(0), uses.Edge(1), uses.Edge(2)) + 1;
  }

  // Gathers each distinct vertex once, one a thread.
  __device__ __forceinline__ void Vertices() {
    if (threadIdx.x >= corners_) return;
    const unsigned use = Shared::CornerUse(threadIdx.x);
    const uint32_t vertex = Shared::Patch(use % kLanes).Vertex(static_cast<int>(use / kLanes));
    const auto* from = reinterpret_cast<const double2*>(launch_.plan.vertices + vertex);
    auto* to = reinterpret_cast<double2*>(&Shared::Vertex(threadIdx.x));
#pragma unroll
    for (size_t k = 0; k < sizeof(DeviceVertex) / sizeof(double2); ++k) to[k] = from[k];
    if constexpr (kWeighted) {
      Shared::CornerWeight(threadIdx.x) = static_cast<float>(launch_.plan.weights.vertices[vertex]);
    }
  }

  // The corners and edges of this warp.
  __device__ __forceinline__ void Evaluate(int warp, unsigned lane) {
    if (warp == kCornerWarp) {
      for (unsigned n = lane; n < corners_; n += kLanes) EvaluateCorner(n);
    }
    if (warp < kEdgeWarps && launch_.segments > 1) {
      const unsigned begin = static_cast<unsigned>(warp) * kLanes + lane;
      for (unsigned n = begin; n < edges_; n += kEdgeWarps * kLanes) EvaluateEdge(n);
    }
  }

 private:
  __device__ uint32_t PatchOf(unsigned use) const { return first_patch_ + use % kLanes; }

  __device__ __forceinline__ void EvaluateCorner(unsigned number) {
    const unsigned use = Shared::CornerUse(number);
    const int slot = static_cast<int>(use / kLanes);
    const DevicePatch& patch = Shared::Patch(use % kLanes);
    const DeviceVertex& vertex = Shared::Vertex(number);
    const uint32_t box = OwnerOf(launch_, {PatchOf(use), patch.Box(), static_cast<uint32_t>(slot),
                                           patch.CornerSteps(slot), patch.CornerOnSeam(slot)});
    float l[3], at[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      l[i] = static_cast<float>(LocalCoordinate(launch_, vertex, box, i));
    }
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, box, component, c);
      PointJet<D0, D1, D2, false>::Evaluate(c, l, at + component);
    }
    if constexpr (kWeighted) {
      const Vec3f rest = ToFloat(RestPoint(launch_, vertex.world));
      const float weight = Shared::CornerWeight(number);
      at[0] = fmaf(weight, at[0], rest.x);
      at[1] = fmaf(weight, at[1], rest.y);
      at[2] = fmaf(weight, at[2], rest.z);
    }
    Shared::Set(Shared::CornerAt(number), sink_.MakePosition({at[0], at[1], at[2]}));
  }

  // An edge at rest and its weight, f(tau) = middle + tau rise. Exchanging the ends changes the sign of the rise.
  struct RestEdge {
    float middle[4], rise[4];  // x, y, z and the weight

    __device__ __forceinline__ RestEdge(const FusedLaunch& launch, unsigned from, unsigned to) {
      const Vec3d a = RestPoint(launch, Shared::Vertex(from).world);
      const Vec3d b = RestPoint(launch, Shared::Vertex(to).world);
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        middle[i] = static_cast<float>(0.5 * ((&a.x)[i] + (&b.x)[i]));
        rise[i] = static_cast<float>((&b.x)[i] - (&a.x)[i]);
      }
      const float w0 = Shared::CornerWeight(from), w1 = Shared::CornerWeight(to);
      middle[3] = 0.5f * (w0 + w1), rise[3] = w1 - w0;
    }
    // Turns displacements at -tau and tau into positions.
    __device__ __forceinline__ void Place(float tau, float* left, float* right) const {
      const float w_left = fmaf(-rise[3], tau, middle[3]), w_right = fmaf(rise[3], tau, middle[3]);
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        left[i] = fmaf(w_left, left[i], fmaf(-rise[i], tau, middle[i]));
        right[i] = fmaf(w_right, right[i], fmaf(rise[i], tau, middle[i]));
      }
    }
  };
  struct NoEdge {
    __device__ NoEdge(const FusedLaunch&, unsigned, unsigned) {}
    __device__ void Place(float, float*, float*) const {}
  };

  // The inner points of an edge, in the direction of its first use.
  __device__ __forceinline__ void EvaluateEdge(unsigned number) {
    const unsigned use = Shared::EdgeUse(number);
    const int slot = static_cast<int>(use / kLanes);
    const DevicePatch& patch = Shared::Patch(use % kLanes);
    const FeatureUses uses = Shared::Uses(use % kLanes);
    const unsigned first = uses.Corner(slot), last = uses.Corner(slot == 2 ? 0 : slot + 1);
    const DeviceVertex &from = Shared::Vertex(first), &to = Shared::Vertex(last);
    const uint32_t box =
        OwnerOf(launch_, {PatchOf(use), patch.Box(), static_cast<uint32_t>(slot) + 3,
                          patch.EdgeSteps(slot), patch.EdgeOnSeam(slot)});
    float midpoint[3], direction[3], p[3][N + 1];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const double a = LocalCoordinate(launch_, from, box, i);
      const double b = LocalCoordinate(launch_, to, box, i);
      midpoint[i] = static_cast<float>(0.5 * (a + b));
      direction[i] = static_cast<float>(b - a);
    }
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, box, component, c);
      EdgeComposition<D0, D1, D2>::Compose(c, midpoint, direction, p[component]);
    }
    const std::conditional_t<kWeighted, RestEdge, NoEdge> rest(launch_, first, last);
    const float unit = 0.5f / static_cast<float>(launch_.segments);
    for (int low = 1; 2 * low <= launch_.segments; ++low) {
      const int high = launch_.segments - low;
      const float tau = static_cast<float>(high - low) * unit;
      float left[3], right[3];
#pragma unroll
      for (int component = 0; component < 3; ++component) {
        float even, odd;
        SplitPowers<N>(p[component], tau * tau, even, odd);
        left[component] = fmaf(-odd, tau, even);
        right[component] = fmaf(odd, tau, even);
      }
      rest.Place(tau, left, right);
      Shared::Set(Shared::EdgePointAt(number, low),
                  sink_.MakePosition({left[0], left[1], left[2]}));
      Shared::Set(Shared::EdgePointAt(number, high),
                  sink_.MakePosition({right[0], right[1], right[2]}));
    }
  }

  const FusedLaunch& launch_;
  const VertexSink<kFloat> sink_;
  const uint32_t first_patch_;
  unsigned corners_ = 0, edges_ = 0;  // of the chunk
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_FEATURES_CUH_
