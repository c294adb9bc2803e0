// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From Taylor coefficients of a patch to its vertices, row by row.
//
//   row t       p_i = sum_j P_ij t^j / j!,   P_ij = d^i/dx^i d^j/dt^j; rows t and -t share their sums
//   point x     position = sum_i p_i x^i / i!,   d/dx = sum_i p_(i+1) x^i / i!;  likewise x and -x
//   normal      P_along x P_across; with vertex normals as WriteSmoothRows says. Made also for views
//               without normals, which do not store it: a branch a point would cost all others
//
// Points on the patch's edges take their positions from shared memory: fused_features.cuh.
#ifndef LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_
#define LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_

#include <limits>

#include "core/ffd/tessellation_pattern.h"
#include "cuda/fused/fused_shared.cuh"
#include "cuda/fused/fused_store.cuh"

namespace latticed::kernels {

// Coefficients of the rows t (plus) and -t (minus); powers[j] = t^j / j!.
template <int N>
__device__ __forceinline__ void CollapseRows(const float* p, const float* powers, float* plus,
                                             float* minus) {
#pragma unroll
  for (int i = 0; i <= N; ++i) {
    float even = p[At(i, 0)];
    if (i == N) {
      plus[i] = minus[i] = even;
      continue;
    }
    float odd = p[At(i, 1)] * powers[1];
#pragma unroll
    for (int j = 2; j <= N - i; ++j) {
      float& part = j % 2 == 0 ? even : odd;
      part = fmaf(p[At(i, j)], powers[j], part);
    }
    plus[i] = even + odd;
    minus[i] = even - odd;
  }
}

// p(±x) = even ± x odd for Taylor coefficients of degree N.
template <int N>
__device__ __forceinline__ void SplitRow(const float* p, const float* steps, float& even,
                                         float& odd) {
  constexpr int kEven = N - N % 2, kOdd = N - 1 + N % 2;
  even = p[kEven];
  odd = p[kOdd];
#pragma unroll
  for (int i = kEven - 2; i >= 0; i -= 2) even = fmaf(even, steps[i + 1], p[i]);
#pragma unroll
  for (int i = kOdd - 2; i >= 1; i -= 2) odd = fmaf(odd, steps[i + 1], p[i]);
}

// Values at x and -x, x = steps[0].
template <int N>
__device__ __forceinline__ void AtBoth(const float* p, const float* steps, float& at_x,
                                       float& at_minus_x) {
  float even, odd;
  SplitRow<N>(p, steps, even, odd);
  at_x = fmaf(odd, steps[0], even);
  at_minus_x = fmaf(-odd, steps[0], even);
}

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// NaN where either is.
__device__ __forceinline__ float MinOrNan(float a, float b) {
  float result;
  asm("min.NaN.f32 %0, %1, %2;" : "=f"(result) : "f"(a), "f"(b));
  return result;
}

__device__ __forceinline__ float3 CrossProduct(float3 a, float3 b) {
  return {fmaf(a.y, b.z, -a.z * b.y), fmaf(a.z, b.x, -a.x * b.z), fmaf(a.x, b.y, -a.y * b.x)};
}

// One row of a patch: polynomials in x of all components.
template <int N, bool kSmooth>
struct FusedRow {
  float position[3][N + 1];
  float across[3][N];
  float facet[3][kSmooth ? N : 1];
};

// What a point's normal is made of.
struct Tangents {
  float3 along, across, facet;
};

template <int N, bool kSmooth, bool kFloat>
class RowKernel {
 public:
  using Shared = FusedShared<N, kSmooth, kFloat>;
  using Row = FusedRow<N, kSmooth>;
  using Sink = VertexSink<kFloat>;
  using Position = typename Sink::Position;

  // `uses` of the lane's patch.
  __device__ RowKernel(const FusedLaunch& launch, const FeatureUses& uses, uint32_t chunk,
                       unsigned lane)
      : sink_(launch, chunk, lane),
        uses_(uses),
        lane_(lane),
        segments_(launch.segments),
        unit_(0.5f / static_cast<float>(launch.segments)),
        weak_below_(Shared::Frame(kWeakBelow, lane)),
        scale_(Shared::Frame(kNormalScale, lane)) {}

  // Whether Shared::Weak has any lane in the rows that were run; the same in all lanes.
  __device__ bool any_weak() const { return any_weak_; }

  // Rows `low` and segments - low, low <= segments / 2.
  __device__ __forceinline__ void Run(int low) {
    const int high = segments_ - low;
    const float t = static_cast<float>(high - low) * unit_;
    constexpr float kInverse[10] = {0,        1.0f,     1.0f / 2, 1.0f / 3, 1.0f / 4,
                                    1.0f / 5, 1.0f / 6, 1.0f / 7, 1.0f / 8, 1.0f / 9};
    float powers[N + 1];
    powers[0] = 1;
#pragma unroll
    for (int j = 1; j <= N; ++j) powers[j] = powers[j - 1] * (t * kInverse[j]);
    Row plus, minus;
#pragma unroll
    for (int c = 0; c < 3; ++c) Collapse(c, powers, plus, minus);
    EvaluateRow(low, -t, minus);
    if (high != low) EvaluateRow(high, t, plus);
  }

 private:
  __device__ __forceinline__ void Collapse(int c, const float* powers, Row& plus, Row& minus) {
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

  // Where the next two points go, at -x and x; from the ends of a row inwards.
  struct Places {
    unsigned left, right;
    int step;
  };

  // Points at -x come first in the pattern in rows of even number, those at x in the others.
  __device__ __forceinline__ Places PlacesOf(int row) const {
    const int stride = static_cast<int>(sink_.stride());
    const unsigned first = sink_.Place(RowBegin(segments_, row));
    const unsigned last = first + static_cast<unsigned>((segments_ - row) * stride);
    return row % 2 == 0 ? Places{first, last, stride} : Places{last, first, -stride};
  }

  __device__ __forceinline__ void EvaluateRow(int row, float t, const Row& r) {
    least_ = kInfinity;
    Places places = PlacesOf(row);
    if (row == 0) {
      EvaluateBottom(r, t, places);
    } else {
      EvaluateInner(row, r, t, places);
    }
    const unsigned weak = __ballot_sync(~0u, !(least_ > weak_below_));  // NaN too
    if (lane_ == 0) Shared::Weak(row) = weak;
    any_weak_ |= weak != 0;
  }

  // Row 0, all of it on edge 0.
  __device__ __forceinline__ void EvaluateBottom(const Row& r, float t, Places& places) {
    unsigned left = Shared::CornerAt(uses_.Corner(0)), right = Shared::CornerAt(uses_.Corner(1));
    int k = 1;
    for (int m = segments_; m > 0; m -= 2, ++k) {
      float steps[4 * Shared::kStepVectors];
      LoadSteps(m, steps);
      StorePair(r, steps, t, Shared::Load(left), Shared::Load(right), places);
      left = EdgeAt(0, false, k);
      right = EdgeAt(0, true, k);
    }
    if (segments_ % 2 == 0) StoreMiddle(r, t, Shared::Load(left), places);
  }

  // Any other row; its ends lie on edges 2 and 1.
  __device__ __forceinline__ void EvaluateInner(int row, const Row& r, float t, Places& places) {
    int m = segments_ - row;
    if (m == 0) {
      return StoreMiddle(r, t, Shared::Load(Shared::CornerAt(uses_.Corner(2))), places);
    }
    float steps[4 * Shared::kStepVectors];
    LoadSteps(m, steps);
    StorePair(r, steps, t, Shared::Load(EdgeAt(2, true, row)), Shared::Load(EdgeAt(1, false, row)),
              places);
    for (m -= 2; m > 0; m -= 2) {
      LoadSteps(m, steps);
      float3 left, right;
      AtBoth<N>(r.position[0], steps, right.x, left.x);
      AtBoth<N>(r.position[1], steps, right.y, left.y);
      AtBoth<N>(r.position[2], steps, right.z, left.z);
      StorePair(r, steps, t, sink_.MakePosition(left), sink_.MakePosition(right), places);
    }
    if (m < 0) return;
    StoreMiddle(r, t, sink_.MakePosition({r.position[0][0], r.position[1][0], r.position[2][0]}),
                places);
  }

  // Where the position of point k of an edge stands, counted from the edge's end where `from_end`.
  __device__ __forceinline__ unsigned EdgeAt(int edge, bool from_end, int k) const {
    const bool back = uses_.IsReversed(edge) != from_end;
    return Shared::EdgePointAt(uses_.Edge(edge), back ? segments_ - k : k);
  }

  __device__ __forceinline__ static void LoadSteps(int m, float* steps) {
#pragma unroll
    for (int k = 0; k < Shared::kStepVectors; ++k) {
      const float4 v = Shared::Step(m, k);
      steps[4 * k] = v.x, steps[4 * k + 1] = v.y, steps[4 * k + 2] = v.z, steps[4 * k + 3] = v.w;
    }
  }

  // The points at x = -steps[0] and steps[0], of positions `left` and `right`.
  __device__ __forceinline__ void StorePair(const Row& r, const float* steps, float t,
                                            Position left, Position right, Places& places) {
    Tangents a, b;
    AtBoth<N - 1>(r.position[0] + 1, steps, a.along.x, b.along.x);
    AtBoth<N - 1>(r.position[1] + 1, steps, a.along.y, b.along.y);
    AtBoth<N - 1>(r.position[2] + 1, steps, a.along.z, b.along.z);
    AtBoth<N - 1>(r.across[0], steps, a.across.x, b.across.x);
    AtBoth<N - 1>(r.across[1], steps, a.across.y, b.across.y);
    AtBoth<N - 1>(r.across[2], steps, a.across.z, b.across.z);
    if constexpr (kSmooth) {
      AtBoth<N - 1>(r.facet[0], steps, a.facet.x, b.facet.x);
      AtBoth<N - 1>(r.facet[1], steps, a.facet.y, b.facet.y);
      AtBoth<N - 1>(r.facet[2], steps, a.facet.z, b.facet.z);
    }
    StoreVertex(places.left, left, b, -steps[0], t);
    StoreVertex(places.right, right, a, steps[0], t);
    places.left += places.step;
    places.right -= places.step;
  }

  __device__ __forceinline__ void StoreMiddle(const Row& r, float t, Position p,
                                              const Places& places) {
    Tangents tangents{{r.position[0][1], r.position[1][1], r.position[2][1]},
                      {r.across[0][0], r.across[1][0], r.across[2][0]},
                      {}};
    if constexpr (kSmooth) tangents.facet = {r.facet[0][0], r.facet[1][0], r.facet[2][0]};
    StoreVertex(places.left, p, tangents, 0, t);
  }

  __device__ __forceinline__ void StoreVertex(unsigned place, Position p, const Tangents& tangents,
                                              float x, float t) {
    float3 n = CrossProduct(tangents.along, tangents.across);
    if constexpr (kSmooth) n = CarryNormal(n, tangents, x, t);
    const float norm1 = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    least_ = MinOrNan(least_, norm1);
    sink_.Store(place, p, n, norm1, scale_);
  }

  // The vertex normals' interpolation is linear in b1 = x - t/2 + 1/4 and b2 = t + 1/2.
  __device__ __forceinline__ float3 CarryNormal(float3 n0, const Tangents& tangents, float x,
                                                float t) const {
    const float b1 = x - 0.5f * t + 0.25f, b2 = t + 0.5f, b0 = 1 - b1 - b2;
    float by[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      by[i] = fmaf(b0, Shared::Frame(kVertexNormal + i, lane_),
                   fmaf(b1, Shared::Frame(kVertexNormal + 3 + i, lane_),
                        b2 * Shared::Frame(kVertexNormal + 6 + i, lane_)));
    }
    const float3 n1 = CrossProduct(tangents.across, tangents.facet);
    const float3 n2 = CrossProduct(tangents.facet, tangents.along);
    return {fmaf(by[0], n0.x, fmaf(by[1], n1.x, by[2] * n2.x)),
            fmaf(by[0], n0.y, fmaf(by[1], n1.y, by[2] * n2.y)),
            fmaf(by[0], n0.z, fmaf(by[1], n1.z, by[2] * n2.z))};
  }

  const Sink sink_;
  const FeatureUses uses_;
  const unsigned lane_;
  const int segments_;
  const float unit_;
  const float weak_below_, scale_;
  float least_ = 0;  // |n|_1 in this row
  bool any_weak_ = false;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_ROWS_CUH_
