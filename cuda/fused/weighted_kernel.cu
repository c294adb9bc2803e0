// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of meshes with weights, each by itself (core/ffd/weights/vertex_weights.h). As direct_kernel.cuh, which this one
// follows, it evaluates R and its Jacobian from the polynomials of boxes; then it blends them with the mesh at rest:
//
//   position   x + w (F(x) - x); of a point on the rim from its corner or edge alone, so that neighbours agree
//   normal     cof(J) N, J = dx + w (dF - dx) + (F(x) - x) dw of the patch's own box
//
// A block takes a chunk, a lane a patch, and the warps of a
// block take triples of points in turn.
#include "core/base/limits.h"
#include "cuda/device/dependent_launch.cuh"
#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/direct_points.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/fused/weighted_normal.cuh"
#include "cuda/fused/weighted_patch.cuh"

namespace latticed::kernels {
namespace {

constexpr int kWeightedWarps = 4, kWeightedThreads = kWeightedWarps * kLanes;
// That a multiprocessor must hold at once; the compiler limits the registers to that.
constexpr int kWeightedBlocks = 4;
// A normal is left to the definition where rounding may have changed it by more than a thousandth.
constexpr float kWeakParts = 1e3f;
// The most segments with which each triple that a warp takes has a bit of its own.
constexpr int kFewSegments = 36;

template <bool kFloat>
__device__ __noinline__ void ReplaceNormal(const WeightedLaunch& launch, uint32_t chunk,
                                           unsigned lane, int row, int column) {
  const double over = 1.0 / launch.fused.segments;
  const Vec3d b{(launch.fused.segments - row - column) * over, column * over, row * over};
  const VertexSink<kFloat> sink(launch.fused, chunk, lane);
  sink.StoreNormal(sink.Place(PointIndex(launch.fused.segments, row, column)),
                   ToFloat(WeightedNormal(launch, chunk * kLanes + lane, b)));
}

template <int D0, int D1, int D2>
class WeightedWarp {
 public:
  __device__ __forceinline__ WeightedWarp(const WeightedLaunch& launch, uint32_t chunk,
                                          unsigned lane)
      : launch_(launch),
        fused_(launch.fused),
        chunk_(chunk),
        lane_(lane),
        // Lanes past the last patch repeat it.
        patch_(launch.fused, min(chunk * kLanes + lane, launch.fused.patch_count - 1)),
        weighted_(launch, min(chunk * kLanes + lane, launch.fused.patch_count - 1)) {}

  // Every kWeightedWarps-th triple, from the one of this number on.
  __device__ __forceinline__ void Run(int first) {
    InTurn(first, [&](const DirectTriple& triple, uint64_t bit) {
      if (!Evaluate(triple)) weak_ |= bit;
    });
    if (weak_ == 0 || fused_.normals == Normals::kNone) return;
    if (chunk_ * kLanes + lane_ >= fused_.patch_count) return;
    InTurn(first, [&](const DirectTriple& triple, uint64_t bit) {
      if ((weak_ & bit) == 0) return;
      for (int r = 0; r < 3; ++r) {
        if (IsFloat()) {
          ReplaceNormal<true>(launch_, chunk_, lane_, triple.Row(r), triple.Column(r));
        } else {
          ReplaceNormal<false>(launch_, chunk_, lane_, triple.Row(r), triple.Column(r));
        }
      }
    });
  }

 private:
  __device__ bool IsFloat() const { return fused_.output.format == LaneFormat::kFloat32; }

  // Returns whether float32 has all three normals.
  __device__ __forceinline__ bool Evaluate(const DirectTriple& triple) {
    const Barycentrics barycentrics(triple);
    float place[3][3], at[3][kRestNumbers];
#pragma unroll
    for (int r = 0; r < 3; ++r) PlacePoint(triple, barycentrics, r, place[r], at[r]);
    DirectJet jet[3];
    EvaluateJets<D0, D1, D2>(fused_, patch_.box(), place, jet);
    float error[3][3];
#pragma unroll
    for (int r = 0; r < 3; ++r) weighted_.Combine(at[r], jet[r], error[r]);
    if (triple.IsOnRim()) {
      EvaluateByOwners<D0, D1, D2>(
          fused_, patch_, triple, [&](int r, int component, float deformed) {
            jet[r][component][0] =
                fmaf(at[r][kWeight], deformed - at[r][component], at[r][component]);
          });
    }
    return IsFloat() ? Store<true>(triple, barycentrics, jet, error)
                     : Store<false>(triple, barycentrics, jet, error);
  }

  // Calls take(triple, bit). Of many segments four triples share a bit.
  template <class Take>
  __device__ __forceinline__ void InTurn(int first, const Take& take) {
    static_assert(PointsPerPatch(limits::kMaxSegments) < 3 * 4 * 64 * kWeightedWarps &&
                  PointsPerPatch(kFewSegments) < 3 * 64 * kWeightedWarps);
    const int sharing = fused_.segments > kFewSegments ? 2 : 0;
    DirectTriple triple(fused_.segments);
    int others = first, turn = 0;
    do {
      if (others-- > 0) continue;
      take(triple, uint64_t{1} << (turn++ >> sharing));
      others = kWeightedWarps - 1;
    } while (triple.Next());
  }

  // The place of the r-th point of the triple in its box, and at rest.
  __device__ __forceinline__ void PlacePoint(const DirectTriple& triple,
                                             const Barycentrics& barycentrics, int r, float* place,
                                             float* at) const {
    const int next = (r + 1) % 3, last = (r + 2) % 3;
    const float* const a = patch_.corner(r).place;
    const float* const b = patch_.corner(next).place;
    if (triple.IsOnRim()) {
      PlaceOnEdge(a, b, triple.steps[1], fused_.segments, place);
      PlaceOnEdge<kRestNumbers>(weighted_.corner(r), weighted_.corner(next), triple.steps[1],
                                fused_.segments, at);
      return;
    }
    const float* const c = patch_.corner(last).place;
#pragma unroll
    for (int i = 0; i < 3; ++i) place[i] = barycentrics.Blend(a[i], b[i], c[i]);
#pragma unroll
    for (int i = 0; i < kRestNumbers; ++i) {
      at[i] = barycentrics.Blend(weighted_.corner(r)[i], weighted_.corner(next)[i],
                                 weighted_.corner(last)[i]);
    }
  }

  template <bool kFloat>
  __device__ __forceinline__ bool Store(const DirectTriple& triple,
                                        const Barycentrics& barycentrics, const DirectJet* jet,
                                        const float (*error)[3]) const {
    using Vertex = typename VertexSink<kFloat>::Vertex;
    const VertexSink<kFloat> sink(fused_, chunk_, lane_);
    unsigned places[3];
    bool strong = true;
    Vertex vertices[3];
#pragma unroll
    for (int r = 0; r < 3; ++r) {
      float conormal[3];
      BlendConormals(patch_, barycentrics, r, conormal);
      const float3 normal = CofactorTimes(jet[r], conormal);
      const float norm1 = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
      const Bounds bounds(jet[r], conormal, error[r]);
      strong &= bounds.IsStrong(norm1);
      places[r] = sink.Place(triple.Index(r));
      vertices[r] = sink.MakeVertex(sink.MakePosition({jet[r][0][0], jet[r][1][0], jet[r][2][0]}),
                                    normal, norm1, 1 / bounds.length);
    }
    sink.Store(places, vertices);
    return strong;
  }

  // Of cof(J) n: its length is no more than `length`, and rounding changed it by no more than `error`.
  struct Bounds {
    float length, error;

    __device__ __forceinline__ Bounds(const DirectJet& jet, const float* n, const float* errors) {
      float column[3];
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        column[i] = fabsf(jet[0][3 - i]) + fabsf(jet[1][3 - i]) + fabsf(jet[2][3 - i]);
      }
      length = error = 0;
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const float size = fabsf(n[i]);
        length = fmaf(size, column[a] * column[b], length);
        error = fmaf(size, fmaf(errors[a], column[b], column[a] * errors[b]), error);
      }
    }
    // False for NaN.
    __device__ __forceinline__ bool IsStrong(float norm1) const {
      constexpr auto kWeak = static_cast<float>(kWeakNormal);
      return norm1 > fmaf(kWeakParts, error, kWeak * length) && norm1 < kInfinity &&
             length > static_cast<float>(kShortestNormal);
    }
  };

  const WeightedLaunch& launch_;
  const FusedLaunch& fused_;
  const uint32_t chunk_;
  const unsigned lane_;
  const DirectPatch patch_;
  const WeightedPatch weighted_;
  uint64_t weak_ = 0;  // triples that have a weak normal
};

template <int D0, int D1, int D2>
__global__ void __launch_bounds__(kWeightedThreads, kWeightedBlocks)
    WeightedKernel(const __grid_constant__ WeightedLaunch launch) {
  const FusedLaunch& fused = launch.fused;
  const uint32_t chunk = fused.chunks != nullptr ? fused.chunks[blockIdx.x] : blockIdx.x;
  WeightedWarp<D0, D1, D2> warp(launch, chunk, threadIdx.x % kLanes);
  // Only the plan and the list of chunks were read before this line: an earlier kernel brought them.
  WaitForKernelBefore();
  warp.Run(static_cast<int>(threadIdx.x / kLanes));
}

}  // namespace

KernelCall WeightedCall(const WeightedLaunch& launch) {
  return CallByDegree(launch.fused.tables.degree, [&]<int D0, int D1, int D2> {
    return KernelCall(&WeightedKernel<D0, D1, D2>, Order::kDependent, launch.fused.chunk_count,
                      kWeightedThreads, 0, launch);
  });
}

}  // namespace latticed::kernels
