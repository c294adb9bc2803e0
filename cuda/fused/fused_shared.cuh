// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared memory of a block of the fused kernel. Each row holds one float, or one vector of floats, for each
// lane.
#ifndef LATTICED_CUDA_FUSED_FUSED_SHARED_CUH_
#define LATTICED_CUDA_FUSED_FUSED_SHARED_CUH_

#include "core/base/limits.h"
#include "cuda/fused/fused_geometry.cuh"
#include "cuda/fused/fused_polynomial.cuh"
#include "cuda/fused/fused_store.cuh"

namespace latticed::kernels {

// N: the degree of a patch.
template <int N, bool kSmooth, bool kFloat, bool kWeighted>
class FusedShared {
 public:
  // Taylor coefficients of one component: of P, of P_across and, with smooth normals, of P_facet.
  static constexpr int kAcrossAt = Terms(N), kFacetAt = kAcrossAt + Terms(N - 1);
  static constexpr int kNumbers = kFacetAt + (kSmooth ? Terms(N - 1) : 0);
  static constexpr int kVectors = (kNumbers + 3) / 4;
  using Position = typename VertexSink<kFloat>::Position;

  LATTICED_HD static constexpr size_t Bytes(int segments) {
    return sizeof(float) * static_cast<size_t>(kEdgesAt + (segments - 1) * kWords * kUses);
  }

  __device__ static float4& Coefficients(int component, int vector, unsigned lane) {
    return Vectors()[(component * kVectors + vector) * kLanes + lane];
  }
  __device__ static float& Frame(int row, unsigned lane) {
    return Floats()[kFrameAt + row * kLanes + lane];
  }
  // For each row of points, the lanes with a weak normal in it, as bits.
  __device__ static unsigned& Weak(int row) {
    return reinterpret_cast<unsigned*>(Floats())[kWeakAt + row];
  }
  // The chunk's patches, uses and distinct vertices. The coefficients overwrite them later.
  __device__ static DevicePatch& Patch(unsigned lane) {
    return reinterpret_cast<DevicePatch*>(Vectors())[lane];
  }
  __device__ static FeatureUses& Uses(unsigned lane) {
    return reinterpret_cast<FeatureUses*>(Vectors() + kLanes)[lane];
  }
  __device__ static DeviceVertex& Vertex(unsigned corner) {
    return reinterpret_cast<DeviceVertex*>(Vectors() + kLanes + kLanes / 2)[corner];
  }
  // Their weights.
  __device__ static float& CornerWeight(unsigned corner) {
    return reinterpret_cast<float*>(&Vertex(kUses))[corner];
  }
  // Lane and slot of the first use of a corner or edge: lane | slot << 5.
  __device__ static uint8_t& CornerUse(unsigned number) { return Bytes8()[kUsesAt * 4 + number]; }
  __device__ static uint8_t& EdgeUse(unsigned number) {
    return Bytes8()[kUsesAt * 4 + kUses + number];
  }
  // Positions of the chunk's corners, and of its edges' inner points k = 1 … segments - 1.
  __device__ static __forceinline__ unsigned CornerAt(unsigned number) {
    return kCornersAt + number;
  }
  __device__ static __forceinline__ unsigned EdgePointAt(unsigned number, int k) {
    return static_cast<unsigned>(kEdgesAt + (k - 1) * kWords * kUses) + number;
  }
  // The words of a position are kUses words apart.
  __device__ static __forceinline__ Position Load(unsigned at) {
    const float* word = Floats() + at;
    if constexpr (kFloat) {
      return {word[0], word[kUses], word[2 * kUses]};
    } else {
      return {__float_as_uint(word[0]), __float_as_uint(word[kUses])};
    }
  }
  __device__ static __forceinline__ void Set(unsigned at, Position p) {
    float* word = Floats() + at;
    if constexpr (kFloat) {
      word[0] = p.x, word[kUses] = p.y, word[2 * kUses] = p.z;
    } else {
      word[0] = __uint_as_float(p.x), word[kUses] = __uint_as_float(p.y);
    }
  }

 private:
  static constexpr int kRows = limits::kMaxSegments + 1;
  static constexpr int kUses = 3 * kLanes;  // uses of corners; as many of edges
  static constexpr int kWords = VertexSink<kFloat>::kPositionWords;
  static constexpr int kFrameAt = 3 * kVectors * 4 * kLanes;
  static constexpr int kFrameRows = kPlainRows<kSmooth> + (kWeighted ? kWeightRows : 0);
  static constexpr int kWeakAt = kFrameAt + kFrameRows * kLanes;
  static constexpr int kUsesAt = kWeakAt + kRows;
  static constexpr int kCornersAt = kUsesAt + 2 * kUses / 4;
  static constexpr int kEdgesAt = kCornersAt + kWords * kUses;
  static_assert(kLanes * (sizeof(DevicePatch) + sizeof(FeatureUses)) +
                    kUses * (sizeof(DeviceVertex) + (kWeighted ? sizeof(float) : 0)) <=
                kFrameAt * sizeof(float));

  // Declared here, not passed as a pointer, so that the compiler knows that it is shared memory.
  __device__ static float4* Vectors() {
    extern __shared__ float4 fused_shared[];
    return fused_shared;
  }
  __device__ static float* Floats() { return reinterpret_cast<float*>(Vectors()); }
  __device__ static uint8_t* Bytes8() { return reinterpret_cast<uint8_t*>(Vectors()); }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_SHARED_CUH_
