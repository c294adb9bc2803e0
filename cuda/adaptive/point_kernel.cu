// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertices of a view with a tolerance, one thread a point, written in wire layout.
//                                                              Twin of core/cpu/adaptive/kernel/adaptive_run-inl.h
//
//   position   R of the box that owns the point, at a place whose bits are the same from both sides (flat_patterns.h)
//   normal     cof(J) N, J the Jacobian of R of the patch's own box and N interpolated from the corners; where the
//              products cancel, that of the definition
//   weights    cuda/fused/weighted_patch.cuh
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/adaptive/point_site.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/fused/call_by_degree.h"
#include "cuda/fused/direct_patch.cuh"
#include "cuda/fused/fused_coefficients.cuh"
#include "cuda/fused/fused_point.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/fused/weighted_patch.cuh"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {
namespace {

// Blocks that a multiprocessor must hold at once; the compiler limits the registers to that. N is the sum of the degrees.
template <int N>
constexpr int PointBlocksAtOnce() {
  return N <= 6 ? 4 : 3;
}

// Writes one vertex.
class PointSink {
 public:
  __device__ __forceinline__ PointSink(const AdaptiveLaunch& launch, const PointSite& site)
      : output_(launch.fused.output),
        points_(site.chunk_points),
        floats_(launch.fused.normals == Normals::kNone ? 3 : 6) {
    const bool is_float = output_.format == LaneFormat::kFloat32;
    const bool is_wide = output_.format == LaneFormat::kQuantised16;
    const unsigned quantised = floats_ == 3 ? 6 : is_wide ? 10 : 8;
    const unsigned bytes = is_float ? floats_ * static_cast<unsigned>(sizeof(float)) : quantised;
    chunk_ = output_.vertices + site.chunk_first * bytes;
    at_ = site.in_chunk;
  }

  // For quantised formats `p` is 0 to 1 over the quantisation box. NaN becomes 0.
  __device__ __forceinline__ void StorePosition(const float (&p)[3]) const {
    if (IsFloat()) return StoreFloats(0, {p[0], p[1], p[2]});
#pragma unroll
    for (unsigned axis = 0; axis < 3; ++axis) {
      Plane(axis)[at_] =
          static_cast<uint16_t>(__float_as_uint(fmaf(__saturatef(p[axis]), output_.top, kRound)));
    }
  }
  // `n` has the normal's direction, `norm1` = |n|_1; `scale` keeps its square in float's range.
  __device__ __forceinline__ void StoreNormal(float3 n, float norm1, float scale) const {
    if (!IsFloat()) {
      const auto centre = static_cast<float>((1 << (output_.normal_bits - 1)) - 1);
      const uint2 st = QuantiseDirection(n, norm1, centre);
      return StoreOctahedral(CanonicaliseOctahedral(
          {static_cast<int32_t>(st.x & 0xffff), static_cast<int32_t>(st.y & 0xffff)},
          output_.normal_bits));
    }
    n = {n.x * scale, n.y * scale, n.z * scale};
    const float inverse = rsqrtf(fmaf(n.x, n.x, fmaf(n.y, n.y, n.z * n.z)));
    StoreFloats(3, {n.x * inverse, n.y * inverse, n.z * inverse});
  }
  __device__ void StoreUnitNormal(Vec3f n) const {
    if (IsFloat()) return StoreFloats(3, {n.x, n.y, n.z});
    StoreOctahedral(QuantiseNormal(n, output_.normal_bits));
  }

 private:
  __device__ __forceinline__ bool IsFloat() const { return output_.format == LaneFormat::kFloat32; }
  __device__ __forceinline__ uint16_t* Plane(unsigned plane) const {
    return reinterpret_cast<uint16_t*>(chunk_) + size_t{plane} * points_;
  }
  __device__ __forceinline__ void StoreFloats(unsigned first, float3 v) const {
    float* to = reinterpret_cast<float*>(chunk_) + size_t{at_} * floats_ + first;
    to[0] = v.x, to[1] = v.y, to[2] = v.z;
  }
  __device__ __forceinline__ void StoreOctahedral(OctahedralNormal n) const {
    if (output_.format == LaneFormat::kQuantised16) {
      Plane(3)[at_] = static_cast<uint16_t>(n.s);
      Plane(4)[at_] = static_cast<uint16_t>(n.t);
      return;
    }
    auto* const bytes = reinterpret_cast<uint8_t*>(Plane(3));
    bytes[at_] = static_cast<uint8_t>(n.s);
    bytes[points_ + at_] = static_cast<uint8_t>(n.t);
  }

  const FusedOutput& output_;
  const uint32_t points_;  // of the chunk
  const unsigned floats_;  // of a vertex in kFloat32
  uint8_t* chunk_;
  uint32_t at_;
};

// Not inlined, and finds the point again, so that the kernel needs no registers for it.
__device__ __noinline__ void StoreDefinitionNormal(const AdaptiveLaunch& launch, uint64_t point) {
  const PointSite site = SiteOf(launch, point);
  const Vec3d normal = DefinitionNormal(launch.fused.plan, launch.fused.control_points, site.patch,
                                        Between(site.place).Barycentrics(),
                                        launch.fused.normals == Normals::kSmooth);
  PointSink(launch, site).StoreUnitNormal(ToFloat(normal));
}

template <int D0, int D1, int D2, bool kWeighted>
class PointThread {
  static constexpr int kStride = CoefficientStride(D0, D1, D2);
  using Weights = PatchWeights<kWeighted>;

 public:
  __device__ __forceinline__ PointThread(const FusedLaunch& launch, const PointSite& site)
      : launch_(launch),
        kind_(site.place.Kind()),
        place_(site.place),
        index_(site.patch),
        patch_(launch, site.patch),
        weights_(launch, site.patch) {}

  // Returns whether the normal is left to the definition.
  __device__ __forceinline__ bool Run(const PointSink& sink) const {
    float l[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      l[i] = place_.Of(patch_.corner(0).place[i], patch_.corner(1).place[i],
                       patch_.corner(2).place[i]);
    }
    const float weight =
        weights_.WeightAt(0, [&](float c0, float c1, float c2) { return place_.Of(c0, c1, c2); });
    Jet jet;
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, patch_.box(), component, c);
      PointJet<D0, D1, D2, true>::Evaluate(c, l, jet[component]);
      const auto row = Weights::RowOf(launch_, patch_.box(), component);
      weights_.Combine(row, l, weight, jet[component]);
    }
    float position[3] = {jet[0][0], jet[1][0], jet[2][0]};
    if (kind_ != PatternPlace::kInside) TakeFromOwner(weight, position);
    sink.StorePosition(position);
    return launch_.normals != Normals::kNone && !StoreNormal(jet, sink);
  }

 private:
  // By component of R: the value, then the derivatives by coordinates 2, 1 and 0.
  using Jet = float[3][4];

  // The position on an edge or at a corner that another box owns, from that box's polynomial.
  __device__ __forceinline__ void TakeFromOwner(float weight, float* position) const {
    const uint32_t owner = kind_ < 3 ? patch_.OwnerOfCorner(kind_) : patch_.OwnerOfEdge(kind_ - 3);
    if (owner == patch_.box()) return;
    float from[3], to[3], l[3];
    patch_.PlaceCorner(place_.a, owner, from);
    patch_.PlaceCorner(place_.b, owner, to);
#pragma unroll
    for (int i = 0; i < 3; ++i) l[i] = Between::OnLine(from[i], to[i], place_.along);
#pragma unroll
    for (int component = 0; component < 3; ++component) {
      float c[kStride];
      LoadCoefficients<kStride>(launch_, owner, component, c);
      float value;
      PointJet<D0, D1, D2, false>::Evaluate(c, l, &value);
      const auto row = Weights::RowOf(launch_, owner, component);
      position[component] = Weights::Position(row, l, weight, value);
    }
  }

  // Returns false where the products cancel.
  __device__ __forceinline__ bool StoreNormal(const Jet& jet, const PointSink& sink) const {
    const NormalRange range = patch_.Range(Weights::CofactorBound(launch_, patch_.box(), index_));
    const float3 n = Carry(jet);
    const float norm1 = fabsf(n.x) + fabsf(n.y) + fabsf(n.z);
    if (!(norm1 > range.weak_below && norm1 < kInfinity)) return false;  // also for NaN
    sink.StoreNormal(n, norm1, range.scale);
    return true;
  }

  // cof(J) N.
  __device__ __forceinline__ float3 Carry(const Jet& jet) const {
    float n[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      n[i] = place_.Of(patch_.corner(0).conormal[i], patch_.corner(1).conormal[i],
                       patch_.corner(2).conormal[i]);
    }
    return CofactorTimes(jet, n);
  }

  const FusedLaunch& launch_;
  const int kind_;
  const Between place_;
  const uint32_t index_;  // of the patch
  const DirectPatch patch_;
  const Weights weights_;
};

template <int D0, int D1, int D2, bool kWeighted>
__global__ void __launch_bounds__(kBlockThreads, (PointBlocksAtOnce<D0 + D1 + D2>()))
    PointsKernel(const __grid_constant__ AdaptiveLaunch launch) {
  const uint64_t total = launch.state.chunk_first[launch.plan_chunks], point = Item();
  if (point >= total || total > launch.most_points) return;
  const PointSite site = SiteOf(launch, point);
  const PointThread<D0, D1, D2, kWeighted> thread(launch.fused, site);
  if (thread.Run(PointSink(launch, site))) StoreDefinitionNormal(launch, point);
}

}  // namespace

KernelCall PointsCall(const AdaptiveLaunch& launch) {
  const unsigned blocks = Blocks(launch.most_points > 0 ? launch.most_points : 1);
  const bool weighted = launch.fused.plan.weights.vertices != nullptr;
  return CallByDegree(launch.fused.tables.degree, [&]<int D0, int D1, int D2> {
    const auto kernel =
        weighted ? &PointsKernel<D0, D1, D2, true> : &PointsKernel<D0, D1, D2, false>;
    return KernelCall(kernel, Order::kAfter, blocks, kBlockThreads, 0, launch);
  });
}

}  // namespace latticed::kernels
