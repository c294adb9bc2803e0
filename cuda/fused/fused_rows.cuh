// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From Taylor coefficients of a patch to its vertices, row by row.
//
//   row t       polynomials in x of P, P_across and P_facet: fused_row_polynomial.cuh
//   point x     position = sum_i p_i x^i / i!,   d/dx = sum_i p_(i+1) x^i / i!
//   normal      P_along x P_across; with smooth normals the formula of WriteSmoothRows. Views without
//               normals compute it too, and do not store it: a branch for each point costs all other
//               views more
//
// Points on the patch's edges take their positions from shared memory: fused_features.cuh.
#ifndef LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_
#define LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_

#include "core/ffd/tessellation_pattern.h"
#include "cuda/fused/fused_row_polynomial.cuh"
#include "cuda/fused/fused_shared.cuh"
#include "cuda/fused/fused_store.cuh"

namespace latticed::kernels {

// NaN when a or b is NaN.
__device__ __forceinline__ float MinOrNan(float a, float b) {
  float result;
  asm("min.NaN.f32 %0, %1, %2;" : "=f"(result) : "f"(a), "f"(b));
  return result;
}

// One row of a patch: polynomials in x of all components.
template <int N, bool kSmooth>
struct FusedRow {
  float position[3][size_t{N} + 1];
  float across[3][size_t{N}];
  float facet[3][kSmooth ? size_t{N} : 1];
};

// Derivatives of P at a point, from which its normal is computed.
struct Tangents {
  float3 along, across, facet;
};

template <int N, bool kSmooth, bool kFloat, bool kWeighted>
class RowKernel {
 public:
  using Shared = FusedShared<N, kSmooth, kFloat, kWeighted>;
  using Row = FusedRow<N, kSmooth>;
  using Step = RowStep<N>;
  using Sink = VertexSink<kFloat>;
  using Position = typename Sink::Position;
  using Vertex = typename Sink::Vertex;

  // `uses`: those of the lane's patch.
  __device__ RowKernel(const FusedLaunch& launch, const FeatureUses& uses, uint32_t chunk,
                       unsigned lane)
      : sink_(launch, chunk, lane),
        uses_(uses),
        lane_(lane),
        segments_(launch.segments),
        unit_(0.5f / static_cast<float>(launch.segments)),
        weak_below_(Shared::Frame(kWeakBelow, lane)),
        scale_(Shared::Frame(kNormalScale, lane)) {}

  // Whether a lane has a weak normal in any row so far; the same for all lanes of the warp.
  __device__ bool any_weak() const { return any_weak_; }

  // Rows `low` and segments - low, low <= segments / 2.
  __device__ __forceinline__ void Run(int low) {
    const int high = segments_ - low;
    const float t = static_cast<float>(high - low) * unit_;
    const RowPowers<N> powers(t);
    Row plus, minus;
#pragma unroll
    for (int c = 0; c < 3; ++c) Collapse(c, powers, plus, minus);
    EvaluateRow<true>(low, -t, minus);
    if (high != low) EvaluateRow<false>(high, t, plus);
  }

 private:
  __device__ __forceinline__ void Collapse(int c, const RowPowers<N>& powers, Row& plus,
                                           Row& minus) {
    float p[4 * Shared::kVectors];
#pragma unroll
    for (int k = 0; k < Shared::kVectors; ++k) {
      const float4 v = Shared::Coefficients(c, k, lane_);
      p[4 * k] = v.x, p[4 * k + 1] = v.y, p[4 * k + 2] = v.z, p[4 * k + 3] = v.w;
    }
    CollapseRows<N>(p, powers, plus.position[c], minus.position[c]);
    CollapseRows<N - 1>(p + Shared::kAcrossAt, powers, plus.across[c], minus.across[c]);
    if constexpr (kSmooth) {
      CollapseRows<N - 1>(p + Shared::kFacetAt, powers, plus.facet[c], minus.facet[c]);
    }
  }

  // Where the next two points of a row are stored, at -x and x, going from its ends inwards.
  struct Places {
    unsigned left, right;
    int step;
  };

  // In the pattern, even rows begin with the point of smallest x, odd rows with that of largest x.
  __device__ __forceinline__ Places PlacesOf(int row) const {
    const int stride = static_cast<int>(sink_.stride());
    const unsigned first = sink_.Place(RowBegin(segments_, row));
    const unsigned last = first + static_cast<unsigned>((segments_ - row) * stride);
    return row % 2 == 0 ? Places{first, last, stride} : Places{last, first, -stride};
  }

  template <bool kMayBeBottom>
  __device__ __forceinline__ void EvaluateRow(int row, float t, const Row& r) {
    least_ = kInfinity;
    if constexpr (kSmooth) InterpolateNormals(t);
    Places places = PlacesOf(row);
    if (kMayBeBottom && row == 0) {
      EvaluateBottom(r, places);
    } else {
      EvaluateInner(row, r, places);
    }
    const unsigned weak = __ballot_sync(~0u, !(least_ > weak_below_));  // true for NaN
    if (lane_ == 0) Shared::Weak(row) = weak;
    any_weak_ |= weak != 0;
  }

  // Row 0: all its points lie on edge 0.
  __device__ __forceinline__ void EvaluateBottom(const Row& r, Places& places) {
    unsigned left = Shared::CornerAt(uses_.Corner(0)), right = Shared::CornerAt(uses_.Corner(1));
    int k = 1;
    for (int m = segments_; m > 0; m -= 2, ++k) {
      StorePair(r, StepTo(m), Shared::Load(left), Shared::Load(right), places);
      left = EdgeAt(0, false, k);
      right = EdgeAt(0, true, k);
    }
    if (segments_ % 2 == 0) StoreMiddle(r, Shared::Load(left), places);
  }

  // Any other row; its ends lie on edges 2 and 1.
  __device__ __forceinline__ void EvaluateInner(int row, const Row& r, Places& places) {
    int m = segments_ - row;
    if (m == 0) {
      return StoreMiddle(r, Shared::Load(Shared::CornerAt(uses_.Corner(2))), places);
    }
    StorePair(r, StepTo(m), Shared::Load(EdgeAt(2, true, row)), Shared::Load(EdgeAt(1, false, row)),
              places);
    for (m -= 2; m > 0; m -= 2) {
      const Step step = StepTo(m);
      float3 left, right;
      AtBoth<N>(r.position[0], step, right.x, left.x);
      AtBoth<N>(r.position[1], step, right.y, left.y);
      AtBoth<N>(r.position[2], step, right.z, left.z);
      StorePair(r, step, sink_.MakePosition(left), sink_.MakePosition(right), places);
    }
    if (m < 0) return;
    StoreMiddle(r, sink_.MakePosition({r.position[0][0], r.position[1][0], r.position[2][0]}),
                places);
  }

  // Where the position of point k of an edge is stored; k is counted from the edge's end if `from_end`.
  __device__ __forceinline__ unsigned EdgeAt(int edge, bool from_end, int k) const {
    const bool back = uses_.IsReversed(edge) != from_end;
    return Shared::EdgePointAt(uses_.Edge(edge), back ? segments_ - k : k);
  }

  // The point m half segments from the middle of a row.
  __device__ __forceinline__ Step StepTo(int m) const {
    return Step(static_cast<float>(m) * unit_);
  }

  // Stores the points at -x and x, whose positions are `left` and `right`.
  __device__ __forceinline__ void StorePair(const Row& r, const Step& step, Position left,
                                            Position right, Places& places) {
    Tangents a, b;
    AtBoth<N - 1>(r.position[0] + 1, step, a.along.x, b.along.x);
    AtBoth<N - 1>(r.position[1] + 1, step, a.along.y, b.along.y);
    AtBoth<N - 1>(r.position[2] + 1, step, a.along.z, b.along.z);
    AtBoth<N - 1>(r.across[0], step, a.across.x, b.across.x);
    AtBoth<N - 1>(r.across[1], step, a.across.y, b.across.y);
    AtBoth<N - 1>(r.across[2], step, a.across.z, b.across.z);
    if constexpr (kSmooth) {
      AtBoth<N - 1>(r.facet[0], step, a.facet.x, b.facet.x);
      AtBoth<N - 1>(r.facet[1], step, a.facet.y, b.facet.y);
      AtBoth<N - 1>(r.facet[2], step, a.facet.z, b.facet.z);
    }
    sink_.Store({places.left, places.right},
                {MakeVertex(left, b, -step.x), MakeVertex(right, a, step.x)});
    places.left += places.step;
    places.right -= places.step;
  }

  __device__ __forceinline__ void StoreMiddle(const Row& r, Position p, const Places& places) {
    Tangents tangents{{r.position[0][1], r.position[1][1], r.position[2][1]},
                      {r.across[0][0], r.across[1][0], r.across[2][0]},
                      {}};
    if constexpr (kSmooth) tangents.facet = {r.facet[0][0], r.facet[1][0], r.facet[2][0]};
    sink_.Store({places.left}, {MakeVertex(p, tangents, 0)});
  }

  __device__ __forceinline__ Vertex MakeVertex(Position p, const Tangents& tangents, float x) {
    float3 n = CrossProduct(tangents.along, tangents.across);
    if constexpr (kSmooth) n = CarryNormal(n, tangents, x);
    const float norm1 = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    least_ = MinOrNan(least_, norm1);
    return sink_.MakeVertex(p, n, norm1, scale_);
  }

  // Interpolates the corners' normals along row t: linear in b1 = x - t/2 + 1/4 and b2 = t + 1/2.
  __device__ __forceinline__ void InterpolateNormals(float t) {
    const float b1 = 0.25f - 0.5f * t, b2 = t + 0.5f;  // b0 = b1 at x = 0
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const float n0 = Shared::Frame(kVertexNormal + i, lane_),
                  n1 = Shared::Frame(kVertexNormal + 3 + i, lane_),
                  n2 = Shared::Frame(kVertexNormal + 6 + i, lane_);
      normal_[i] = fmaf(b1, n0 + n1, b2 * n2);
      normal_slope_[i] = n1 - n0;
    }
  }

  __device__ __forceinline__ float3 CarryNormal(float3 n0, const Tangents& tangents,
                                                float x) const {
    const float by0 = fmaf(normal_slope_[0], x, normal_[0]),
                by1 = fmaf(normal_slope_[1], x, normal_[1]),
                by2 = fmaf(normal_slope_[2], x, normal_[2]);
    const float3 n1 = CrossProduct(tangents.across, tangents.facet);
    const float3 n2 = CrossProduct(tangents.facet, tangents.along);
    return {fmaf(by0, n0.x, fmaf(by1, n1.x, by2 * n2.x)),
            fmaf(by0, n0.y, fmaf(by1, n1.y, by2 * n2.y)),
            fmaf(by0, n0.z, fmaf(by1, n1.z, by2 * n2.z))};
  }

  const Sink sink_;
  const FeatureUses uses_;
  const unsigned lane_;
  const int segments_;
  const float unit_;
  const float weak_below_, scale_;
  float least_ = 0;  // |n|_1 in this row
  // The interpolated vertex normal of this row at x = 0, and by x; smooth only.
  float normal_[kSmooth ? 3 : 1] = {}, normal_slope_[kSmooth ? 3 : 1] = {};
  bool any_weak_ = false;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_
