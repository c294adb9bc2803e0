// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From Taylor coefficients of a patch to its vertices, row by row.
//
//   row t       p_i = sum_j P_ij t^j / j!,   P_ij = d^i/dx^i d^j/dt^j; rows t and -t share their sums
//   point x     position = sum_i p_i x^i / i!,   d/dx = sum_i p_(i+1) x^i / i!;  likewise x and -x
//   normal      P_along x P_across; with vertex normals as WriteSmoothRows says
//
// Points on the patch's edges take their positions from shared memory: fused_edge.cuh.
#ifndef LATTICED_CUDA_FUSED_ROWS_CUH_
#define LATTICED_CUDA_FUSED_ROWS_CUH_

#include "core/ffd/tessellation_pattern.h"
#include "cuda/fused_geometry.cuh"
#include "cuda/fused_polynomial.cuh"
#include "cuda/fused_store.cuh"

namespace latticed::kernels {

constexpr int kLanes = 32;

// Shared memory of a block, in floats; every row has a float or a vector of floats a lane.
template <int N, bool kSmooth>
struct FusedShape {
  // A component's coefficients: P, P_across, and with vertex normals P_facet.
  static constexpr int kAcrossAt = Terms(N), kFacetAt = kAcrossAt + Terms(N - 1);
  static constexpr int kNumbers = kFacetAt + (kSmooth ? Terms(N - 1) : 0);
  static constexpr int kVectors = (kNumbers + 3) / 4;
  static constexpr int kFrameRows = kSmooth ? kSmoothRows : kFacetRows;
  // x, then x^2 / (i (i + 1)) for i = 1 … N - 1.
  static constexpr int kSteps = (N + 3) / 4 * 4;
};
template <int N, bool kSmooth>
struct FusedShared {
  using Shape = FusedShape<N, kSmooth>;
  float4 (*coefficients)[Shape::kVectors][kLanes];  // [component]
  float (*steps)[Shape::kSteps];                    // [segments + 1]: x = index / (2 segments)
  float (*frame)[kLanes];                           // FrameRow
  float (*boundary)[3][kLanes];                     // [edge * segments + k][component]
  unsigned* weak;                                   // [row]: lanes with a weak normal

  LATTICED_HD static size_t Bytes(int segments) {
    return sizeof(float) * (kLanes * (12 * Shape::kVectors + Shape::kFrameRows + 9 * segments) +
                            (segments + 1) * (Shape::kSteps + 1));
  }
  __device__ FusedShared(float4* bytes, int segments) {
    coefficients = reinterpret_cast<decltype(coefficients)>(bytes);
    steps = reinterpret_cast<decltype(steps)>(coefficients + 3);
    frame = reinterpret_cast<decltype(frame)>(steps + segments + 1);
    boundary = reinterpret_cast<decltype(boundary)>(frame + Shape::kFrameRows);
    weak = reinterpret_cast<unsigned*>(boundary + 3 * segments);
  }
};

// Coefficients of the rows t (plus) and -t (minus); powers[j] = t^j / j!.
template <int N>
__device__ __forceinline__ void CollapseRows(const float* p, const float* powers, float* plus,
                                             float* minus) {
#pragma unroll
  for (int i = 0; i <= N; ++i) {
    float even = p[At(i, 0)], odd = 0.0f;
    if (i < N) odd = p[At(i, 1)] * powers[1];
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

template <int N, bool kSmooth>
class RowKernel {
 public:
  using Shared = FusedShared<N, kSmooth>;
  using Shape = typename Shared::Shape;

  __device__ RowKernel(const FusedLaunch& launch, const Shared& shared, uint32_t chunk,
                       unsigned lane)
      : shared_(shared),
        sink_(launch, chunk, lane),
        lane_(lane),
        segments_(launch.segments),
        normals_(launch.normals != Normals::kNone),
        weak_below_(shared.frame[kWeakBelow][lane]),
        scale_(shared.frame[kNormalScale][lane]) {}

  // Rows `low` and segments - low, low <= segments / 2.
  __device__ void Run(int low) {
    const int high = segments_ - low;
    const float t = static_cast<float>(high - low) / static_cast<float>(2 * segments_);
    float powers[N + 1];
    powers[0] = 1;
#pragma unroll
    for (int j = 1; j <= N; ++j) powers[j] = powers[j - 1] * (t / static_cast<float>(j));
    FusedRow<N, kSmooth> plus, minus;
#pragma unroll
    for (int c = 0; c < 3; ++c) Collapse(c, powers, plus, minus);
    EvaluateRow(low, -t, minus);
    if (high != low) EvaluateRow(high, t, plus);
  }

 private:
  __device__ __forceinline__ void Collapse(int c, const float* powers, FusedRow<N, kSmooth>& plus,
                                           FusedRow<N, kSmooth>& minus) {
    float p[4 * Shape::kVectors];
#pragma unroll
    for (int k = 0; k < Shape::kVectors; ++k) {
      const float4 v = shared_.coefficients[c][k][lane_];
      p[4 * k] = v.x, p[4 * k + 1] = v.y, p[4 * k + 2] = v.z, p[4 * k + 3] = v.w;
    }
    CollapseRows<N>(p, powers, plus.position[c], minus.position[c]);
    CollapseRows<N - 1>(p + Shape::kAcrossAt, powers, plus.across[c], minus.across[c]);
    if constexpr (kSmooth) {
      CollapseRows<N - 1>(p + Shape::kFacetAt, powers, plus.facet[c], minus.facet[c]);
    }
  }

  // From the ends inwards, two points at a time. The ends lie on edges 2 and 1, all of row 0 on
  // edge 0.
  __device__ void EvaluateRow(int row, float t, const FusedRow<N, kSmooth>& r) {
    weak_ = false;
    const int last = segments_ - row, begin = RowBegin(segments_, row);
    const int left_end = (2 * segments_ + last) % (3 * segments_), right_end = segments_ + row;
    for (int k = 0; 2 * k < last; ++k) {
      const bool odd = row % 2 != 0;
      const int left = begin + (odd ? last - k : k), right = begin + (odd ? k : last - k);
      const bool on_edge = k == 0 || row == 0;
      const int left_at = k == 0 ? left_end : k, right_at = k == 0 ? right_end : last - k;
      EvaluatePair(r, last - 2 * k, t, on_edge, left, left_at, right, right_at);
    }
    if (last % 2 == 0) {
      EvaluateMiddle(r, t, row == 0 || last == 0, begin + last / 2, row == 0 ? last / 2 : right_end);
    }
    const unsigned weak = __ballot_sync(~0u, weak_);
    if (lane_ == 0) shared_.weak[row] = weak;
  }

  __device__ __forceinline__ float3 Boundary(int at) const {
    const float(*p)[kLanes] = shared_.boundary[at];
    return {p[0][lane_], p[1][lane_], p[2][lane_]};
  }

  // Values at x and -x.
  template <int kDegree>
  __device__ __forceinline__ static void AtBoth(const float* p, const float* steps, float& right,
                                                float& left) {
    float even, odd;
    SplitRow<kDegree>(p, steps, even, odd);
    right = fmaf(odd, steps[0], even);
    left = fmaf(-odd, steps[0], even);
  }
  template <int kDegree, class Rows>
  __device__ __forceinline__ static void AtBoth(const Rows& rows, int shift, const float* steps,
                                                float3& right, float3& left) {
    AtBoth<kDegree>(rows[0] + shift, steps, right.x, left.x);
    AtBoth<kDegree>(rows[1] + shift, steps, right.y, left.y);
    AtBoth<kDegree>(rows[2] + shift, steps, right.z, left.z);
  }

  // x = step / (2 segments) on the right, -x on the left.
  __device__ __forceinline__ void EvaluatePair(const FusedRow<N, kSmooth>& r, int step, float t,
                                               bool on_edge, int left, int left_at, int right,
                                               int right_at) {
    float steps[Shape::kSteps];
#pragma unroll
    for (int i = 0; i < Shape::kSteps; ++i) steps[i] = shared_.steps[step][i];
    float3 p_left, p_right;
    if (on_edge) {
      p_left = Boundary(left_at);
      p_right = Boundary(right_at);
    } else {
      AtBoth<N>(r.position, 0, steps, p_right, p_left);
    }
    if (!normals_) {
      sink_.Store(left, p_left);
      return sink_.Store(right, p_right);
    }
    float3 along_left, along_right, across_left, across_right, facet_left{}, facet_right{};
    AtBoth<N - 1>(r.position, 1, steps, along_right, along_left);
    AtBoth<N - 1>(r.across, 0, steps, across_right, across_left);
    if constexpr (kSmooth) AtBoth<N - 1>(r.facet, 0, steps, facet_right, facet_left);
    Store(left, p_left, along_left, across_left, facet_left, -steps[0], t);
    Store(right, p_right, along_right, across_right, facet_right, steps[0], t);
  }

  __device__ __forceinline__ void EvaluateMiddle(const FusedRow<N, kSmooth>& r, float t,
                                                 bool on_edge, int point, int at) {
    float3 p{r.position[0][0], r.position[1][0], r.position[2][0]};
    if (on_edge) p = Boundary(at);
    if (!normals_) return sink_.Store(point, p);
    const float3 along{r.position[0][1], r.position[1][1], r.position[2][1]};
    const float3 across{r.across[0][0], r.across[1][0], r.across[2][0]};
    float3 facet{};
    if constexpr (kSmooth) facet = {r.facet[0][0], r.facet[1][0], r.facet[2][0]};
    Store(point, p, along, across, facet, 0, t);
  }

  __device__ __forceinline__ void Store(int point, float3 p, float3 along, float3 across,
                                        float3 facet, float x, float t) {
    float3 n = CrossProduct(along, across);
    if constexpr (kSmooth) n = CarryNormal(n, along, across, facet, x, t);
    const float norm1 = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    weak_ |= !(norm1 > weak_below_);  // NaN too
    sink_.Store(point, p, n, norm1, scale_);
  }

  // The vertex normals' interpolation is linear in b1 = x - t/2 + 1/4 and b2 = t + 1/2.
  __device__ __forceinline__ float3 CarryNormal(float3 n0, float3 along, float3 across,
                                                float3 facet, float x, float t) const {
    const float b1 = x - 0.5f * t + 0.25f, b2 = t + 0.5f, b0 = 1 - b1 - b2;
    float by[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const float(*corner)[kLanes] = shared_.frame + kVertexNormal + i;
      by[i] = fmaf(b0, corner[0][lane_], fmaf(b1, corner[3][lane_], b2 * corner[6][lane_]));
    }
    const float3 n1 = CrossProduct(across, facet), n2 = CrossProduct(facet, along);
    return {fmaf(by[0], n0.x, fmaf(by[1], n1.x, by[2] * n2.x)),
            fmaf(by[0], n0.y, fmaf(by[1], n1.y, by[2] * n2.y)),
            fmaf(by[0], n0.z, fmaf(by[1], n1.z, by[2] * n2.z))};
  }

  const Shared& shared_;
  const VertexSink sink_;
  const unsigned lane_;
  const int segments_;
  const bool normals_;
  const float weak_below_, scale_;
  bool weak_ = false;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_ROWS_CUH_
