// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A patch in the registers of a lane of the direct kernel: its corners and their normals, in coordinates
// of the patch's box.
#ifndef LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_
#define LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_

#include "cuda/fused/fused_geometry.cuh"

namespace latticed::kernels {

struct DirectCorner {
  float place[3];  // box-local
  // cof(A) N, where N is the normal at the corner and A the Jacobian of box-local coordinates by world
  // position. The cofactors of the polynomial's Jacobian map it to cof(J) N. It is scaled so that the
  // largest component of the patch is 1.
  float conormal[3];
};

// A coordinate of the k-th of `segments` + 1 points on a line. Point k from one end is bit for bit point
// `segments` - k from the other end.
__device__ __forceinline__ float OnEdge(float from, float to, int k, int segments) {
  const float tau = static_cast<float>(2 * k - segments) * (0.5f / static_cast<float>(segments));
  return k == 0 ? from : fmaf(to - from, tau, 0.5f * (from + to));
}
__device__ __forceinline__ void PlaceOnEdge(const float* from, const float* to, int k, int segments,
                                            float* place) {
#pragma unroll
  for (int i = 0; i < 3; ++i) place[i] = OnEdge(from[i], to[i], k, segments);
}

class DirectPatch {
 public:
  // Reads only the plan.
  __device__ __forceinline__ DirectPatch(const FusedLaunch& launch, uint32_t index)
      : launch_(launch),
        index_(index),
        patch_(launch.plan.patches[index]),
        facet_(launch.plan.facet_normals[index]) {
#pragma unroll
    for (int c = 0; c < 3; ++c) PlaceCorner(c, box(), corner_[c].place);
    SetConormals();
  }

  __device__ uint32_t box() const { return patch_.Box(); }
  // `cofactor_bound`: of ||cof J||, J the Jacobian by world position.
  __device__ __forceinline__ NormalRange Range(double cofactor_bound) const {
    const double bound = cofactor_bound * per_unit_;
    return RangeOfNormals(bound, bound);
  }

  __device__ const DirectCorner& corner(int c) const { return corner_[c]; }
  // The place of corner c in coordinates of `box`.
  __device__ __forceinline__ void PlaceCorner(int c, uint32_t box, float* place) const {
    const DevicePatch corner{{Word(c), 0, 0, 0}};
    const DeviceVertex& vertex = launch_.plan.vertices[corner.Vertex(0)];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      place[i] = static_cast<float>(LocalCoordinate(launch_, vertex, box, i));
    }
  }
  // The box that owns a corner, or the inner points of the edge that begins there.
  __device__ __forceinline__ uint32_t OwnerOfCorner(int c) const {
    return OwnerOf(launch_, {index_, box(), static_cast<uint32_t>(c), patch_.CornerSteps(c),
                             patch_.CornerOnSeam(c)});
  }
  __device__ __forceinline__ uint32_t OwnerOfEdge(int e) const {
    const DevicePatch edge{{Word(e), 0, 0, 0}};
    return OwnerOf(launch_, {index_, box(), static_cast<uint32_t>(e) + 3, edge.EdgeSteps(0),
                             edge.EdgeOnSeam(0)});
  }

 private:
  // An index that is not a constant would move the words from registers to memory.
  __device__ __forceinline__ uint32_t Word(int c) const {
    return c == 0 ? patch_.word[0] : c == 1 ? patch_.word[1] : patch_.word[2];
  }
  // With facet normals all three corners have the same.
  __device__ __forceinline__ void SetConormals() {
    const Vec3d* row = launch_.tables.boxes[box()].gradient;
    const Vec3d cofactor[3] = {Cross(row[1], row[2]), Cross(row[2], row[0]), Cross(row[0], row[1])};
    const bool smooth = launch_.normals == Normals::kSmooth;
    const Vec3d facet = UnpackDirection(facet_);
    double conormal[3][3], unit = 0;
#pragma unroll
    for (int c = 0; c < 3; ++c) {
      const Vec3d n = smooth ? ToDouble(launch_.plan.corner_normals[index_].corner[c]) : facet;
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        conormal[c][i] = Dot(cofactor[i], n);
        unit = fmax(unit, fabs(conormal[c][i]));
      }
    }
    per_unit_ = 1 / unit;
#pragma unroll
    for (int c = 0; c < 3; ++c) {
#pragma unroll
      for (int i = 0; i < 3; ++i) {
        corner_[c].conormal[i] = static_cast<float>(conormal[c][i] * per_unit_);
      }
    }
  }

  const FusedLaunch& launch_;
  const uint32_t index_;
  const DevicePatch patch_;
  const PackedDirection facet_;
  double per_unit_;
  DirectCorner corner_[3];
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_
