// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline where points are few: R and its Jacobian at each point, from the polynomial of the
// patch's box as it is, nothing composed and nothing shared.        Twin of core/cpu/fused_direct-inl.h
//
//   position   R of the box that owns the point, at a place whose bits are the same from both sides
//   normal     cof(J) N = n0 J1 x J2 + n1 J2 x J0 + n2 J0 x J1, J the Jacobian of R of the patch's own
//              box and n the conormal of N there, interpolated from the corners
//
// Comes after box_polynomials_kernel.cu, by a dependent launch. A warp is a chunk, a lane a patch;
// corners and edges are evaluated by every patch that has them.
#ifndef LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_
#define LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_

#include "core/ffd/tessellation_pattern.h"
#include "cuda/device/dependent_launch.cuh"
#include "cuda/fused/direct_patch.cuh"
#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_point.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {

constexpr int kDirectWarps = 4;  // of a block, a chunk each
constexpr int kDirectThreads = kDirectWarps * kLanes;
static_assert(PointsPerPatch(kMostDirectSegments) <= 32);  // a bit each

// Blocks that a multiprocessor holds at once, as far as registers go, of degrees that sum to N. With six
// and seven, of fewer registers, 2x2x2 takes as long.
template <int N>
constexpr int DirectBlocksAtOnce() {
  return N <= 6 ? 5 : 4;
}

// A point of a patch, by the corner that comes first.
struct DirectPoint {
  int index;  // in the pattern
  float barycentric[3];
  float place[3];  // in coordinates of the patch's box
  uint32_t owner;  // the box that gives its position
};

// The k-th point of the line between two places in `segments` steps, from its first end on: bit for
// bit the same when the ends change places.
__device__ __forceinline__ void PlaceOnEdge(const float* from, const float* to, int k, int segments,
                                            float step, float* place) {
  const float tau = static_cast<float>(2 * k - segments) * (0.5f * step);
#pragma unroll
  for (int i = 0; i < 3; ++i) {
    const float middle = 0.5f * (from[i] + to[i]);
    place[i] = k == 0 ? from[i] : fmaf(to[i] - from[i], tau, middle);
  }
}

// Normals of one lane's weak points, by the definition. `weak`: bit i is point i. Not inlined, so that
// its registers are no business of the kernel's.
template <bool kFloat>
__device__ __noinline__ void ReplaceWeakNormals(const FusedLaunch& launch, unsigned weak,
                                                uint32_t chunk, unsigned lane) {
  const VertexSink<kFloat> sink(launch, chunk, lane);
  const double over = 1.0 / launch.segments;
  for (int row = 0; row <= launch.segments; ++row) {
    for (int column = 0; column <= launch.segments - row; ++column) {
      const int point = PointIndex(launch.segments, row, column);
      if ((weak >> point & 1) == 0) continue;
      const Vec3d b{(launch.segments - row - column) * over, column * over, row * over};
      const Vec3d n = DefinitionNormal(launch.plan, launch.control_points, chunk * kLanes + lane, b,
                                       launch.normals == Normals::kSmooth);
      sink.StoreNormal(sink.Place(point), ToFloat(n));
    }
  }
}

template <int D0, int D1, int D2>
class DirectWarp {
  static constexpr int kStride = CoefficientStride(D0, D1, D2);

 public:
  __device__ __forceinline__ DirectWarp(const FusedLaunch& launch, uint32_t chunk, unsigned lane)
      : launch_(launch),
        chunk_(chunk),
        lane_(lane),
        // Lanes after the last patch repeat it.
        patch_(launch, min(chunk * kLanes + lane, launch.patch_count - 1)),
        step_(1 / static_cast<float>(launch.segments)) {}

  __device__ __forceinline__ void Run() {
    // Until here the plan was read, and the list of chunks: it came before the kernel waited for.
    WaitForKernelBefore();
    range_ = patch_.Range();
    // One loop, so that the work on a point is there once.
#pragma unroll 1
    for (int left = PointsPerPatch(segments()); left > 0; --left) {
      Evaluate(turn_ < 3 ? RimPoint() : InnerPoint());
      Next();
    }
    if (weak_ == 0 || launch_.normals == Normals::kNone) return;
    if (chunk_ * kLanes + lane_ >= launch_.patch_count) return;
    if (IsFloat()) {
      ReplaceWeakNormals<true>(launch_, weak_, chunk_, lane_);
    } else {
      ReplaceWeakNormals<false>(launch_, weak_, chunk_, lane_);
    }
  }

 private:
  __device__ int segments() const { return launch_.segments; }
  __device__ bool IsFloat() const { return launch_.output.format == LaneFormat::kFloat32; }

  // Edge by edge, each with its first corner, then row by row within.
  __device__ __forceinline__ void Next() {
    if (turn_ == 3) {
      if (++column_ == segments() - row_) ++row_, column_ = 1;
    } else if (++k_ == segments()) {
      patch_.Turn();
      ++turn_, k_ = 0;
    }
  }
  __device__ __forceinline__ DirectPoint RimPoint() const {
    DirectPoint point;
    point.index = EdgePoint(segments(), turn_, k_);
    point.barycentric[1] = static_cast<float>(k_) * step_;
    point.barycentric[0] = 1 - point.barycentric[1];
    point.barycentric[2] = 0;
    PlaceOnEdge(patch_.corner(0).place, patch_.corner(1).place, k_, segments(), step_, point.place);
    point.owner = k_ == 0 ? patch_.OwnerOfCorner(turn_) : patch_.OwnerOfEdge(turn_);
    return point;
  }
  __device__ __forceinline__ DirectPoint InnerPoint() const {
    DirectPoint point;
    point.index = PointIndex(segments(), row_, column_);
    point.barycentric[0] = static_cast<float>(segments() - row_ - column_) * step_;
    point.barycentric[1] = static_cast<float>(column_) * step_;
    point.barycentric[2] = static_cast<float>(row_) * step_;
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      point.place[i] = Blend(point, patch_.corner(0).place[i], patch_.corner(1).place[i],
                             patch_.corner(2).place[i]);
    }
    point.owner = patch_.box();
    return point;
  }
  __device__ __forceinline__ static float Blend(const DirectPoint& point, float a, float b,
                                                float c) {
    const float* w = point.barycentric;
    return fmaf(a, w[0], fmaf(b, w[1], c * w[2]));
  }

  __device__ __forceinline__ void Evaluate(const DirectPoint& point) {
    float jet[3][4];
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, patch_.box(), component, c);
      PointJet<D0, D1, D2, true>::Evaluate(c, point.place, jet[component]);
    }
    float3 position{jet[0][0], jet[1][0], jet[2][0]};
    if (point.owner != patch_.box()) position = PositionIn(point.owner);
    const float3 normal =
        Carry(point, {jet[0][3], jet[1][3], jet[2][3]}, {jet[0][2], jet[1][2], jet[2][2]},
              {jet[0][1], jet[1][1], jet[2][1]});
    const float norm1 = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
    const bool strong = norm1 > range_.weak_below && norm1 < kInfinity;  // not where it is NaN
    if (!strong) weak_ |= 1u << point.index;
    if (IsFloat()) {
      Store<true>(point.index, position, normal, norm1);
    } else {
      Store<false>(point.index, position, normal, norm1);
    }
  }

  // Of the rim's point, where another box than the patch's own gives it.
  __device__ __forceinline__ float3 PositionIn(uint32_t owner) const {
    float from[3], to[3], place[3], at[3];
    patch_.PlaceCorner(0, owner, from);
    patch_.PlaceCorner(1, owner, to);
    PlaceOnEdge(from, to, k_, segments(), step_, place);
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, owner, component, c);
      PointJet<D0, D1, D2, false>::Evaluate(c, place, at + component);
    }
    return {at[0], at[1], at[2]};
  }

  // cof(J) N; j0, j1, j2 are columns of J.
  __device__ __forceinline__ float3 Carry(const DirectPoint& point, float3 j0, float3 j1,
                                          float3 j2) const {
    float n[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      n[i] = Blend(point, patch_.corner(0).conormal[i], patch_.corner(1).conormal[i],
                   patch_.corner(2).conormal[i]);
    }
    // The first two terms are one product.
    const float3 side{fmaf(n[0], j1.x, -n[1] * j0.x), fmaf(n[0], j1.y, -n[1] * j0.y),
                      fmaf(n[0], j1.z, -n[1] * j0.z)};
    const float3 sum = CrossProduct(side, j2), last = CrossProduct(j0, j1);
    return {fmaf(n[2], last.x, sum.x), fmaf(n[2], last.y, sum.y), fmaf(n[2], last.z, sum.z)};
  }

  template <bool kFloat>
  __device__ __forceinline__ void Store(int index, float3 position, float3 normal,
                                        float norm1) const {
    const VertexSink<kFloat> sink(launch_, chunk_, lane_);
    sink.Store({sink.Place(index)},
               {sink.MakeVertex(sink.MakePosition(position), normal, norm1, range_.scale)});
  }

  const FusedLaunch& launch_;
  const uint32_t chunk_;
  const unsigned lane_;
  DirectPatch patch_;
  NormalRange range_;
  const float step_;  // between points, in barycentric coordinates
  int turn_ = 0, k_ = 0, row_ = 1, column_ = 1;
  unsigned weak_ = 0;  // bit i: point i of the pattern
};

template <int D0, int D1, int D2>
__global__ void __launch_bounds__(kDirectThreads, (DirectBlocksAtOnce<D0 + D1 + D2>()))
    DirectKernel(const __grid_constant__ FusedLaunch launch) {
  const uint32_t index = blockIdx.x * kDirectWarps + threadIdx.x / kLanes;
  if (index >= launch.chunk_count) return;
  const uint32_t chunk = launch.chunks != nullptr ? launch.chunks[index] : index;
  DirectWarp<D0, D1, D2>(launch, chunk, threadIdx.x % kLanes).Run();
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_
