// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline for patches with few points. It evaluates R and its Jacobian at each point from the
// polynomial of the patch's box; nothing is composed, and lanes share nothing.
//                                                          Twin of core/cpu/fused/kernel/fused_direct-inl.h
//
//   position   R of the box that owns the point, at a place whose bits are the same from both sides
//   normal     cof(J) N = n0 J1 x J2 + n1 J2 x J0 + n2 J0 x J1, J the Jacobian of R of the patch's own
//              box and n the conormal of N there, interpolated from the corners
//   weights    weighted_patch.cuh
//
// This kernel is a dependent launch after box_polynomials_kernel.cu. A warp takes a chunk, or a part of one
// when chunks are few; a lane takes a patch. Every patch evaluates its own corners and edges. A lane
// evaluates three points with each coefficient that it loads, because loads take longest: a multiprocessor
// needs four cycles to load four numbers for each lane of a warp.
#ifndef LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_
#define LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_

#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"
#include "cuda/device/dependent_launch.cuh"
#include "cuda/fused/direct_points.cuh"
#include "cuda/fused/fused_ahead.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/fused/weak_normal.cuh"
#include "cuda/fused/weighted_patch.cuh"

namespace latticed::kernels {

constexpr int kDirectThreads = kDirectWarps * kLanes;
// Weak points are the bits of one word.
static_assert(PointsPerPatch(MostDirectSegments(3 * limits::kMaxDegree, Normals::kSmooth)) <= 32);

// How many blocks a multiprocessor must hold at once; the compiler limits the registers to that. N is the
// sum of the degrees, one more with weights. One more block leaves fewer registers and takes 1.04 (1x1x1)
// to 1.12 times as long (2x2x2). Blocks of two warps with as many registers take 0.97 to 1.00 times as long
// (3x3x3).
template <int N>
constexpr int DirectBlocksAtOnce() {
  return N <= 6 ? 4 : 3;
}

// Replaces the normals of one lane's weak points by those of the definition. `weak`: bit i is point i. It
// is not inlined, so that the kernel needs no registers for it.
template <bool kFloat>
__device__ __noinline__ void ReplaceWeakNormals(const FusedLaunch& launch, unsigned weak,
                                                uint32_t chunk, unsigned lane) {
  for (int row = 0; row <= launch.segments; ++row) {
    for (int column = 0; column <= launch.segments - row; ++column) {
      if ((weak >> PointIndex(launch.segments, row, column) & 1) == 0) continue;
      ReplaceNormal<kFloat>(launch, chunk, lane, row, column);
    }
  }
}

template <int D0, int D1, int D2, bool kWeighted>
class DirectWarp {
  using Weights = PatchWeights<kWeighted>;

 public:
  __device__ __forceinline__ DirectWarp(const FusedLaunch& launch, FusedBlocks::Part part,
                                        unsigned lane)
      : launch_(launch),
        part_(part),
        chunk_(launch.chunks != nullptr ? launch.chunks[part.index] : part.index),
        lane_(lane),
        // Lanes past the last patch repeat it.
        index_(min(chunk_ * kLanes + lane, launch.patch_count - 1)),
        patch_(launch, index_),
        weights_(launch, index_) {}

  __device__ __forceinline__ void Run() {
    // Only the plan and the list of chunks were read before this line: an earlier kernel brought them.
    WaitForKernelBefore();
    range_ = patch_.Range(Weights::CofactorBound(launch_, patch_.box(), index_));
    DirectTriple triple(launch_.segments);
    uint32_t others = part_.part;  // triples of other warps that come before the next of this one
    do {
      if (others-- > 0) continue;
      Evaluate(triple);
      others = part_.parts - 1;
    } while (triple.Next());
    if (weak_ == 0 || launch_.normals == Normals::kNone) return;
    if (chunk_ * kLanes + lane_ >= launch_.patch_count) return;
    if (IsFloat()) {
      ReplaceWeakNormals<true>(launch_, weak_, chunk_, lane_);
    } else {
      ReplaceWeakNormals<false>(launch_, weak_, chunk_, lane_);
    }
  }

 private:
  __device__ bool IsFloat() const { return launch_.output.format == LaneFormat::kFloat32; }

  __device__ __forceinline__ void Evaluate(const DirectTriple& triple) {
    const Barycentrics barycentrics(triple);
    float place[3][3];
#pragma unroll
    for (int r = 0; r < 3; ++r) PlacePoint(triple, barycentrics, r, place[r]);
    DirectJet jet[3];
    EvaluateJets<D0, D1, D2>(launch_, patch_.box(), place, jet);
    float weight[3];
#pragma unroll
    for (int r = 0; r < 3; ++r) weight[r] = WeightAt(triple, barycentrics, r);
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      const auto row = Weights::RowOf(launch_, patch_.box(), component);
#pragma unroll
      for (int r = 0; r < 3; ++r) {
        weights_.Combine(row, place[r], weight[r], jet[r][component]);
      }
    }
    if (triple.IsOnRim()) {
      const auto take = [&](uint32_t owner, const float* at, int r, int component, float value) {
        const auto row = Weights::RowOf(launch_, owner, component);
        jet[r][component][0] = Weights::Position(row, at, weight[r], value);
      };
      EvaluateByOwners<D0, D1, D2>(launch_, patch_, triple, take);
    }
    if (IsFloat()) {
      Store<true>(triple, barycentrics, jet);
    } else {
      Store<false>(triple, barycentrics, jet);
    }
  }

  // The place of the r-th point of the triple.
  __device__ __forceinline__ void PlacePoint(const DirectTriple& triple,
                                             const Barycentrics& barycentrics, int r,
                                             float* place) const {
    const float* const a = patch_.corner(r).place;
    const float* const b = patch_.corner((r + 1) % 3).place;
    const float* const c = patch_.corner((r + 2) % 3).place;
    if (triple.IsOnRim()) return PlaceOnEdge(a, b, triple.steps[1], launch_.segments, place);
#pragma unroll
    for (int i = 0; i < 3; ++i) place[i] = barycentrics.Blend(a[i], b[i], c[i]);
  }

  __device__ __forceinline__ float WeightAt(const DirectTriple& triple,
                                            const Barycentrics& barycentrics, int r) const {
    return weights_.WeightAt(r, [&](float a, float b, float c) {
      return triple.IsOnRim() ? OnEdge(a, b, triple.steps[1], launch_.segments)
                              : barycentrics.Blend(a, b, c);
    });
  }

  template <bool kFloat>
  __device__ __forceinline__ void Store(const DirectTriple& triple,
                                        const Barycentrics& barycentrics, const DirectJet* jet) {
    using Vertex = typename VertexSink<kFloat>::Vertex;
    const VertexSink<kFloat> sink(launch_, chunk_, lane_);
    unsigned places[3];
    Vertex vertices[3];
#pragma unroll
    for (int r = 0; r < 3; ++r) {
      const int index = triple.Index(r);
      const float3 normal = Carry(barycentrics, r, jet[r]);
      const float norm1 = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
      const bool strong = norm1 > range_.weak_below && norm1 < kInfinity;  // false for NaN
      if (!strong) weak_ |= 1u << index;
      places[r] = sink.Place(index);
      vertices[r] = sink.MakeVertex(sink.MakePosition({jet[r][0][0], jet[r][1][0], jet[r][2][0]}),
                                    normal, norm1, range_.scale);
    }
    sink.Store(places, vertices);
  }

  // cof(J) N.
  __device__ __forceinline__ float3 Carry(const Barycentrics& barycentrics, int r,
                                          const DirectJet& jet) const {
    float n[3];
    BlendConormals(patch_, barycentrics, r, n);
    return CofactorTimes(jet, n);
  }

  const FusedLaunch& launch_;
  const FusedBlocks::Part part_;
  const uint32_t chunk_;
  const unsigned lane_;
  const uint32_t index_;  // of the patch
  const DirectPatch patch_;
  const Weights weights_;
  NormalRange range_;
  unsigned weak_ = 0;  // bit i: point i of the pattern
};

template <int D0, int D1, int D2, bool kWeighted>
__global__ void __launch_bounds__(kDirectThreads,
                                  (DirectBlocksAtOnce<D0 + D1 + D2 + (kWeighted ? 1 : 0)>()))
    DirectKernel(const __grid_constant__ FusedLaunch launch) {
  const uint32_t number = blockIdx.x * kDirectWarps + threadIdx.x / kLanes;
  if (number >= launch.blocks.Count(launch.chunk_count)) return;
  const FusedBlocks::Part part = launch.blocks.PartOf(number);
  const unsigned lane = threadIdx.x % kLanes;
  PlanAhead ahead(launch, part.index + launch.blocks.at_once, lane);
  ahead.BringPartOf(launch.plan.facet_normals);
  if (launch.normals == Normals::kSmooth) ahead.BringPartOf(launch.plan.corner_normals);
  ahead.BringPatches();
  DirectWarp<D0, D1, D2, kWeighted> warp(launch, part, lane);
  ahead.BringVertices();
  warp.Run();
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_KERNEL_CUH_
