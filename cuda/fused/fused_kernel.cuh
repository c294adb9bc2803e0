// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel: from box polynomials to vertices, with nothing in global memory between.
//
// This kernel is a dependent launch after box_polynomials_kernel.cu. A block takes a chunk of 32 patches,
// one a lane. (When chunks are few, several blocks share a chunk: each does steps 1 and 2, and some of the
// rows of step 3.) The three warps of a block
//   1  evaluate the chunk's edges and corners, and compute the patches' frames
//   2  compose one component each, and leave its Taylor coefficients in shared memory; with weights they
//      compose the displacement G, multiply it by w, and add x (core/ffd/weights/vertex_weights.h)
//   3  take rows in turn, and write vertices from registers
//   4  replace the normals that lost their digits to cancellation by those of the definition
#ifndef LATTICED_CUDA_FUSED_FUSED_KERNEL_CUH_
#define LATTICED_CUDA_FUSED_FUSED_KERNEL_CUH_

#include "cuda/device/dependent_launch.cuh"
#include "cuda/fused/fused_ahead.cuh"
#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_features.cuh"
#include "cuda/fused/fused_rows.cuh"
#include "cuda/fused/weak_normal.cuh"

namespace latticed::kernels {

constexpr int kFusedThreads = kFusedWarps * kLanes;

// How many blocks a multiprocessor must hold at once; the compiler limits the registers to that. N is the
// degree of a patch: the sum of the degrees, one more with weights. These were fastest on an H200, at
// 113,663 patches and 10 segments. With one more, registers spill to memory (2x2x2 smooth: 0.135 ms with
// five, 0.109 with four); with one fewer, the multiprocessor is idle more often.
template <int N, bool kSmooth>
constexpr int BlocksAtOnce() {
  constexpr int kLeastSum = 3;
  constexpr int kFacet[] = {8, 7, 5, 5, 4, 4, 4, 4}, kVertex[] = {5, 5, 4, 4, 4, 3, 2, 2};
  return kSmooth ? kVertex[N - kLeastSum] : kFacet[N - kLeastSum];
}

// The pairs of rows, `row` and segments - row, that a warp takes: every `of`-th pair from `first` on.
struct RowTurns {
  int first, of;

  __device__ bool Have(int row, int segments) const {
    return min(row, segments - row) % of == first;
  }
};

// Replaces the normals of a warp's weak points by those of the definition. `weak`: for each row, the lanes
// that have weak points in it. The points are spread over all lanes, whichever lane's patch they are on. It
// is called after the warp has written all vertices of its rows. It is not inlined, so that the kernel
// needs no registers for it.
template <bool kFloat>
__device__ __noinline__ void ReplaceWeakNormals(const FusedLaunch& launch, const unsigned* weak,
                                                uint32_t chunk, RowTurns turns) {
  const int thread = static_cast<int>(threadIdx.x) % kLanes;
  int first = 0;  // points in earlier rows
  for (int row = 0; row <= launch.segments; ++row) {
    if (!turns.Have(row, launch.segments)) continue;
    const int columns = launch.segments - row + 1, points = __popc(weak[row]) * columns;
    // Item i of the warp goes to lane i mod 32.
    for (int item = (thread - first) & (kLanes - 1); item < points; item += kLanes) {
      const int column = item % columns;
      const auto lane = static_cast<unsigned>(__fns(weak[row], 0, item / columns + 1));
      if (chunk * kLanes + lane >= launch.patch_count) continue;
      ReplaceNormal<kFloat>(launch, chunk, lane, row, column);
    }
    first += points;
  }
}

template <int D0, int D1, int D2, bool kSmooth, bool kFloat, bool kWeighted>
class FusedBlock {
  static constexpr int kSum = D0 + D1 + D2, kStride = CoefficientStride(D0, D1, D2);
  static constexpr int N = kSum + (kWeighted ? 1 : 0);  // degree of a patch

 public:
  using Shared = FusedShared<N, kSmooth, kFloat, kWeighted>;

  // `index`: the place of the chunk in the launch.
  __device__ FusedBlock(const FusedLaunch& launch, uint32_t index)
      : launch_(launch),
        index_(index),
        chunk_(launch.chunks != nullptr ? launch.chunks[index] : index),
        warp_(static_cast<int>(threadIdx.x / kLanes)),
        lane_(threadIdx.x % kLanes) {
    const uint32_t patch = chunk_ * kLanes + lane_;
    // Lanes past the last patch repeat it.
    patch_index_ = patch < launch.patch_count ? patch : launch.patch_count - 1;
  }

  __device__ __forceinline__ void Run() {
    const FeatureUses uses = launch_.tables.feature_uses[patch_index_];
    const DevicePatch patch = launch_.plan.patches[patch_index_];
    const bool frames = warp_ == kFrameWarp;
    const PackedDirection facet =
        frames ? launch_.plan.facet_normals[patch_index_] : PackedDirection{};
    PlanAhead ahead(launch_, index_ + launch_.blocks.at_once, lane_);
    if (frames) {
      ahead.BringPartOf(launch_.tables.feature_uses);
      ahead.BringPartOf(launch_.plan.facet_normals);
      if constexpr (kSmooth) ahead.BringPartOf(launch_.plan.corner_normals);
      ahead.BringPatches();
    }
    FeatureKernel<D0, D1, D2, kSmooth, kFloat, kWeighted> features(launch_, chunk_);
    features.Begin(uses, patch, warp_, lane_);
    __syncthreads();
    features.Vertices();
    __syncthreads();
    FrameSize size{};
    if (frames) {
      size = MakeFrame(uses, patch, facet);
      ahead.BringVertices();
    }
    // Only the plan and the list of chunks were read before this line: an earlier kernel brought them.
    WaitForKernelBefore();
    if (frames) BoundNormals(patch.Box(), size);
    features.Evaluate(warp_, lane_);
    __syncthreads();
    Compose(patch.Box());
    __syncthreads();
    RowKernel<N, kSmooth, kFloat, kWeighted> rows(launch_, uses, chunk_, lane_);
    const RowTurns turns = Turns();
    for (int low = turns.first; 2 * low <= launch_.segments; low += turns.of) rows.Run(low);
    if (!rows.any_weak() || launch_.normals == Normals::kNone) return;
    __syncwarp();
    ReplaceWeakNormals<kFloat>(launch_, &Shared::Weak(0), chunk_, turns);
  }

 private:
  __device__ __forceinline__ FrameSize MakeFrame(const FeatureUses& uses, const DevicePatch& patch,
                                                 PackedDirection facet) const {
    const DeviceVertex* const corner[3] = {&Shared::Vertex(uses.Corner(0)),
                                           &Shared::Vertex(uses.Corner(1)),
                                           &Shared::Vertex(uses.Corner(2))};
    double weight[3] = {1, 1, 1};
    if constexpr (kWeighted) {
#pragma unroll
      for (int c = 0; c < 3; ++c) weight[c] = Shared::CornerWeight(uses.Corner(c));
    }
    return WriteFrame<kSmooth, kWeighted>(launch_, patch_index_, patch.Box(),
                                          UnpackDirection(facet), corner, weight,
                                          &Shared::Frame(0, lane_), kLanes);
  }
  // Reads the polynomials.
  __device__ __forceinline__ void BoundNormals(uint32_t box, FrameSize size) const {
    const double by_length = CofactorBound(box, size.steepness) * size.length;
    const double bound = by_length * size.height;
    // Smooth normals have the term P_facet x P_along, and P_facet belongs to a normal of length 1.
    const NormalRange range = RangeOfNormals(bound, kSmooth ? by_length : bound);
    Shared::Frame(kWeakBelow, lane_) = range.weak_below;
    Shared::Frame(kNormalScale, lane_) = range.scale;
  }
  __device__ __forceinline__ RowTurns Turns() const {
    const FusedBlocks::Part part = launch_.blocks.PartOf(blockIdx.x);
    return {static_cast<int>(part.part * kFusedWarps) + warp_,
            static_cast<int>(part.parts * kFusedWarps)};
  }
  __device__ __forceinline__ double CofactorBound(uint32_t box, double steepness) const {
    return kWeighted ? WeightedCofactorBound(launch_, box, steepness)
                     : double{launch_.polynomials.cofactor_bounds[box]};
  }
  // Warp w composes component w.
  __device__ __forceinline__ void Compose(uint32_t box) {
    AffineMap<D2> map;
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      map.l[i][0] = Shared::Frame(kCentre + i, lane_);
      map.l[i][1] = Shared::Frame(kAlong + i, lane_);
      map.l[i][2] = Shared::Frame(kAcross + i, lane_);
      if constexpr (kSmooth) map.normal[i] = Shared::Frame(kFacet + i, lane_);
    }
    map.FormPowers();
    float c[kStride], p[Terms(N)], out[4 * Shared::kVectors];
    LoadCoefficients<kStride>(launch_, box, warp_, c);
    if constexpr (kWeighted) {
      ComposeWeighted(c, map, p, out + Shared::kFacetAt);
    } else {
      Composition<D0, D1, D2, kSmooth>::Compose(c, map, p, out + Shared::kFacetAt);
    }
    ToRowForm(p, Shared::Frame(kShear, lane_), out);
#pragma unroll
    for (int k = 0; k < Shared::kVectors; ++k) {
      Shared::Coefficients(warp_, k, lane_) = {out[4 * k], out[4 * k + 1], out[4 * k + 2],
                                               out[4 * k + 3]};
    }
  }

  // x + w G, and its derivative along the facet normal, where w does not change.
  __device__ __forceinline__ void ComposeWeighted(const float* c, const AffineMap<D2>& map,
                                                  float* p, float* facet) const {
    const auto row = [this](int k) { return Shared::Frame(kPlainRows<kSmooth> + k, lane_); };
    const float weight[3] = {row(kWeight), row(kWeight + 1), row(kWeight + 2)};
    const int own = kRest + 3 * warp_;
    const float rest[3] = {row(own), row(own + 1), row(own + 2)};
    float displacement[Terms(kSum)], by_normal[Terms(kSum - 1)];
    Composition<D0, D1, D2, kSmooth>::Compose(c, map, displacement, by_normal);
    MultiplyLinearAdd<kSum, 1>(displacement, weight, rest, p);
    if constexpr (kSmooth) {
      const float slope[1] = {row(kRestFacet + warp_)};
      MultiplyLinearAdd<kSum - 1, 0>(by_normal, weight, slope, facet);
    }
  }

  // From powers in the frame to Taylor coefficients in sheared rows. P_across is computed before the
  // shear: after it, in a thin patch, it would be a small difference of large numbers.
  __device__ __forceinline__ void ToRowForm(float* p, float shear, float* out) const {
    ToTaylor<N>(p);
    float* across = out + Shared::kAcrossAt;
#pragma unroll
    for (int i = 0; i < N; ++i) {
#pragma unroll
      for (int j = 0; j < N - i; ++j) across[At(i, j)] = p[At(i, j + 1)];
    }
    Shear<N - 1>(across, shear);
    // d/dt = d/d across + shear d/dx.
#pragma unroll
    for (int i = 0; i <= N; ++i) out[At(i, 0)] = p[At(i, 0)];
#pragma unroll
    for (int j = 1; j <= N; ++j) {
#pragma unroll
      for (int i = 0; i <= N - j; ++i) {
        out[At(i, j)] = fmaf(shear, out[At(i + 1, j - 1)], across[At(i, j - 1)]);
      }
    }
    if constexpr (kSmooth) {
      ToTaylor<N - 1>(out + Shared::kFacetAt);
      Shear<N - 1>(out + Shared::kFacetAt, shear);
    }
#pragma unroll
    for (int k = Shared::kNumbers; k < 4 * Shared::kVectors; ++k) out[k] = 0;
  }

  const FusedLaunch& launch_;
  const uint32_t index_, chunk_;
  const int warp_;
  const unsigned lane_;
  uint32_t patch_index_;
};

template <int D0, int D1, int D2, bool kSmooth, bool kFloat, bool kWeighted>
__global__ void __launch_bounds__(kFusedThreads,
                                  (BlocksAtOnce<D0 + D1 + D2 + (kWeighted ? 1 : 0), kSmooth>()))
    FusedKernel(const __grid_constant__ FusedLaunch launch) {
  const uint32_t index = launch.blocks.PartOf(blockIdx.x).index;
  FusedBlock<D0, D1, D2, kSmooth, kFloat, kWeighted>(launch, index).Run();
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_KERNEL_CUH_
