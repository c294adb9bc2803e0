// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared memory of a block of the fused kernel. Every row has a float, or a vector of floats, a lane.
#ifndef LATTICED_CUDA_FUSED_SHARED_CUH_
#define LATTICED_CUDA_FUSED_SHARED_CUH_

#include "core/base/limits.h"
#include "cuda/fused_geometry.cuh"
#include "cuda/fused_polynomial.cuh"
#include "cuda/fused_store.cuh"

namespace latticed::kernels {

constexpr int kLanes = 32;

template <int N, bool kSmooth, bool kFloat>
class FusedShared {
 public:
  // A component's Taylor coefficients: P, P_across, and with vertex normals P_facet.
  static constexpr int kAcrossAt = Terms(N), kFacetAt = kAcrossAt + Terms(N - 1);
  static constexpr int kNumbers = kFacetAt + (kSmooth ? Terms(N - 1) : 0);
  static constexpr int kVectors = (kNumbers + 3) / 4;
  // A step: x = m / (2 segments), then x^2 / (i (i + 1)) for i = 1 … N - 1.
  static constexpr int kStepVectors = (N + 3) / 4;
  using Position = typename VertexSink<kFloat>::Position;
  static constexpr int kBoundaryWords = VertexSink<kFloat>::kPositionWords;

  LATTICED_HD static constexpr size_t Bytes(int segments) {
    return sizeof(float) *
           static_cast<size_t>(kBoundaryAt + 3 * segments * kBoundaryWords * kLanes);
  }

  __device__ static float4& Coefficients(int component, int vector, unsigned lane) {
    return Vectors()[(component * kVectors + vector) * kLanes + lane];
  }
  __device__ static float& Frame(int row, unsigned lane) {
    return Floats()[kFrameAt + row * kLanes + lane];
  }
  __device__ static float4& Step(int m, int vector) {
    return Vectors()[kStepsAt / 4 + m * kStepVectors + vector];
  }
  // Per row, the lanes with a weak normal.
  __device__ static unsigned& Weak(int row) {
    return reinterpret_cast<unsigned*>(Floats())[kWeakAt + row];
  }
  // Positions on edges: at = edge * segments + k.
  __device__ static __forceinline__ Position Boundary(int at, unsigned lane) {
    const float* row = Floats() + kBoundaryAt + at * kBoundaryWords * kLanes + lane;
    if constexpr (kFloat) {
      return {row[0], row[kLanes], row[2 * kLanes]};
    } else {
      return {__float_as_uint(row[0]), __float_as_uint(row[kLanes])};
    }
  }
  __device__ static __forceinline__ void SetBoundary(int at, unsigned lane, Position p) {
    float* row = Floats() + kBoundaryAt + at * kBoundaryWords * kLanes + lane;
    if constexpr (kFloat) {
      row[0] = p.x, row[kLanes] = p.y, row[2 * kLanes] = p.z;
    } else {
      row[0] = __uint_as_float(p.x), row[kLanes] = __uint_as_float(p.y);
    }
  }

 private:
  static constexpr int kRows = limits::kMaxSegments + 1;
  static constexpr int kFrameAt = 3 * kVectors * 4 * kLanes;
  static constexpr int kStepsAt = kFrameAt + (kSmooth ? kSmoothRows : kFacetRows) * kLanes;
  static constexpr int kWeakAt = kStepsAt + kRows * kStepVectors * 4;
  static constexpr int kBoundaryAt = kWeakAt + (kRows + 3) / 4 * 4;

  // Named here and not passed, so that the compiler knows what kind of memory it is.
  __device__ static float4* Vectors() {
    extern __shared__ float4 fused_shared[];
    return fused_shared;
  }
  __device__ static float* Floats() { return reinterpret_cast<float*>(Vectors()); }
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_SHARED_CUH_
