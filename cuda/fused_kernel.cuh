// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel: from box polynomials to vertices, nothing in memory between.   DESIGN §2 "fused"
//
// A block is a chunk, 32 patches, a lane each; its three warps
//   1  make the frames, and evaluate an edge and a corner each, from their owner's polynomial
//   2  compose a component each, and leave its Taylor coefficients in shared memory
//   3  take rows by turns, and write vertices straight from registers
//   4  replace normals that cancelled by those of the definition, where there are any
#ifndef LATTICED_CUDA_FUSED_KERNEL_CUH_
#define LATTICED_CUDA_FUSED_KERNEL_CUH_

#include "cuda/definition_normal.cuh"
#include "cuda/fused_edge.cuh"
#include "cuda/fused_rows.cuh"

namespace latticed::kernels {

constexpr int kFusedWarps = 3, kFusedThreads = kFusedWarps * kLanes;

// The normals of weak rows by the definition, a thread a point, whichever lane it is of. `weak`: per
// row the lanes concerned. Waits for nobody: all vertices of the chunk are written. Not inlined, so
// that its registers are no business of the kernel's.
__device__ __noinline__ void ReplaceWeakNormals(const FusedLaunch& launch, const unsigned* weak,
                                                uint32_t chunk, bool smooth) {
  const VertexSink sink(launch, chunk, 0);
  int first = 0;  // points of the rows before
  for (int row = 0; row <= launch.segments; ++row) {
    const int columns = launch.segments - row + 1, points = __popc(weak[row]) * columns;
    // Item i of the chunk goes to thread i modulo their number.
    const int before = first % kFusedThreads, thread = static_cast<int>(threadIdx.x);
    int item = thread - before + (thread < before ? kFusedThreads : 0);
    for (; item < points; item += kFusedThreads) {
      const int column = item % columns;
      const auto lane = static_cast<unsigned>(__fns(weak[row], 0, item / columns + 1));
      const uint32_t patch = chunk * kLanes + lane;
      if (patch >= launch.patch_count) continue;
      const double over = 1.0 / launch.segments;
      const Vec3d b{(launch.segments - row - column) * over, column * over, row * over};
      const Vec3d n = DefinitionNormal(launch.plan, launch.control_points, patch, b, smooth);
      sink.StoreNormal(PointIndex(launch.segments, row, column), static_cast<int>(lane), ToFloat(n));
    }
    first += points;
  }
}

template <int D0, int D1, int D2, bool kSmooth>
class FusedBlock {
  static constexpr int N = D0 + D1 + D2, kStride = CoefficientStride(D0, D1, D2);
  using Shared = FusedShared<N, kSmooth>;
  using Shape = typename Shared::Shape;

 public:
  __device__ FusedBlock(const FusedLaunch& launch, const Shared& shared, uint32_t chunk)
      : launch_(launch),
        shared_(shared),
        chunk_(chunk),
        warp_(static_cast<int>(threadIdx.x / kLanes)),
        lane_(threadIdx.x % kLanes) {
    const uint32_t patch = chunk * kLanes + lane_;
    // Lanes after the last patch repeat it.
    patch_index_ = patch < launch.patch_count ? patch : launch.patch_count - 1;
    patch_ = launch.plan.patches[patch_index_];
  }

  __device__ void Run() {
    FillSteps();
    if (warp_ == 0) {
      WriteFrame<kSmooth>(launch_, patch_index_, patch_, &shared_.frame[0][lane_], kLanes);
    }
    EvaluateEdge();
    __syncthreads();
    Compose();
    __syncthreads();
    RowKernel<N, kSmooth> rows(launch_, shared_, chunk_, lane_);
    for (int low = warp_; 2 * low <= launch_.segments; low += kFusedWarps) rows.Run(low);
    if (launch_.normals == Normals::kNone) return;
    __syncthreads();
    if (IsAnyWeak()) ReplaceWeakNormals(launch_, shared_.weak, chunk_, kSmooth);
  }

 private:
  __device__ void FillSteps() {
    for (int m = static_cast<int>(threadIdx.x); m <= launch_.segments; m += kFusedThreads) {
      const float x = static_cast<float>(m) / static_cast<float>(2 * launch_.segments);
      shared_.steps[m][0] = x;
#pragma unroll
      for (int i = 1; i < Shape::kSteps; ++i) {
        shared_.steps[m][i] = x * x / static_cast<float>(i * (i + 1));
      }
    }
  }

  __device__ __forceinline__ void LoadCoefficients(uint32_t box, int component, float* c) const {
    const auto* row = reinterpret_cast<const float4*>(
        launch_.polynomials.coefficients + (size_t{box} * 3 + static_cast<unsigned>(component)) *
                                               static_cast<size_t>(kStride));
#pragma unroll
    for (int k = 0; k < kStride / 4; ++k) {
      const float4 v = row[k];
      c[4 * k] = v.x, c[4 * k + 1] = v.y, c[4 * k + 2] = v.z, c[4 * k + 3] = v.w;
    }
  }

  // Edge warp_ without its ends, and the corner that it begins at.
  __device__ void EvaluateEdge() {
    const int next = warp_ == 2 ? 0 : warp_ + 1;
    const uint32_t from = patch_.Vertex(warp_), to = patch_.Vertex(next), own = patch_.Box();
    const uint32_t corner_box =
        OwnerOf(launch_, {patch_index_, own, static_cast<uint32_t>(warp_),
                          patch_.CornerSteps(warp_), patch_.CornerOnSeam(warp_)});
    const uint32_t edge_box =
        OwnerOf(launch_, {patch_index_, own, static_cast<uint32_t>(warp_) + 3,
                          patch_.EdgeSteps(warp_), patch_.EdgeOnSeam(warp_)});
    float corner[3], midpoint[3], direction[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      corner[i] = static_cast<float>(LocalCoordinate(launch_, from, corner_box, i));
      const double a = LocalCoordinate(launch_, from, edge_box, i);
      const double b = LocalCoordinate(launch_, to, edge_box, i);
      midpoint[i] = static_cast<float>(0.5 * (a + b));
      direction[i] = static_cast<float>(b - a);
    }
    const int first = warp_ * launch_.segments;
    for (int component = 0; component < 3; ++component) {
      float c[kStride], p[N + 1];
      LoadCoefficients(edge_box, component, c);
      EdgeComposition<D0, D1, D2>::Compose(c, midpoint, direction, p);
      for (int low = 1; 2 * low <= launch_.segments; ++low) {
        const int high = launch_.segments - low;
        const float tau =
            static_cast<float>(high - low) / static_cast<float>(2 * launch_.segments);
        float even, odd;
        SplitPowers<N>(p, tau * tau, even, odd);
        shared_.boundary[first + low][component][lane_] = fmaf(-odd, tau, even);
        shared_.boundary[first + high][component][lane_] = fmaf(odd, tau, even);
      }
      if (corner_box != edge_box) LoadCoefficients(corner_box, component, c);
      shared_.boundary[first][component][lane_] = EvaluatePoint<D0, D1, D2>(c, corner);
    }
  }

  // Component warp_.
  __device__ void Compose() {
    AffineMap<D2> map;
    const float(*frame)[kLanes] = shared_.frame;
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      map.l[i][0] = frame[kCentre + i][lane_];
      map.l[i][1] = frame[kAlong + i][lane_];
      map.l[i][2] = frame[kAcross + i][lane_];
      if constexpr (kSmooth) map.normal[i] = frame[kFacet + i][lane_];
    }
    map.FormPowers();
    float c[kStride], p[Terms(N)], out[4 * Shape::kVectors];
    LoadCoefficients(patch_.Box(), warp_, c);
    Composition<D0, D1, D2, kSmooth>::Compose(c, map, p, out + Shape::kFacetAt);
    ToRowForm(p, frame[kShear][lane_], out);
#pragma unroll
    for (int k = 0; k < Shape::kVectors; ++k) {
      shared_.coefficients[warp_][k][lane_] = {out[4 * k], out[4 * k + 1], out[4 * k + 2],
                                               out[4 * k + 3]};
    }
  }

  // From powers in the frame to Taylor coefficients in sheared rows. P_across is taken before the
  // shear: afterwards it would be a small difference of large numbers in a thin patch.
  __device__ __forceinline__ void ToRowForm(float* p, float shear, float* out) const {
    ToTaylor<N>(p);
    float* across = out + Shape::kAcrossAt;
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
      ToTaylor<N - 1>(out + Shape::kFacetAt);
      Shear<N - 1>(out + Shape::kFacetAt, shear);
    }
#pragma unroll
    for (int k = Shape::kNumbers; k < 4 * Shape::kVectors; ++k) out[k] = 0;
  }

  __device__ bool IsAnyWeak() const {
    unsigned any = 0;
    for (int row = 0; row <= launch_.segments; ++row) any |= shared_.weak[row];
    return any != 0;
  }

  const FusedLaunch& launch_;
  const Shared& shared_;
  const uint32_t chunk_;
  const int warp_;
  const unsigned lane_;
  uint32_t patch_index_;
  DevicePatch patch_;
};

template <int D0, int D1, int D2, bool kSmooth>
__global__ void __launch_bounds__(kFusedThreads, 5)
    FusedKernel(const __grid_constant__ FusedLaunch launch) {
  extern __shared__ float4 bytes[];
  const FusedShared<D0 + D1 + D2, kSmooth> shared(bytes, launch.segments);
  const uint32_t chunk = launch.chunks != nullptr ? launch.chunks[blockIdx.x] : blockIdx.x;
  FusedBlock<D0, D1, D2, kSmooth>(launch, shared, chunk).Run();
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_KERNEL_CUH_
