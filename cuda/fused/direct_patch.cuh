// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A patch as the direct kernel has it, in the registers of its lane: its corners in coordinates of its
// box, and what its normals are there.
#ifndef LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_
#define LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_

#include "cuda/fused/fused_geometry.cuh"

namespace latticed::kernels {

struct DirectCorner {
  float place[3];  // box-local
  // cof(A) N of its normal N, A the Jacobian of box-local coordinates by world position: what the
  // cofactors of the polynomial's own Jacobian take to cof(J) N. In units of the patch's largest.
  float conormal[3];
};

class DirectPatch {
 public:
  // From nothing but the plan.
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
  // Of its normals, by the polynomials.
  __device__ __forceinline__ NormalRange Range() const {
    return RangeOfNormals(double{launch_.polynomials.cofactor_bounds[box()]} * per_unit_);
  }

  // Corners are counted from the one that comes first now, edges begin at the corner of their number.
  __device__ const DirectCorner& corner(int c) const { return corner_[c]; }
  __device__ __forceinline__ void PlaceCorner(int c, uint32_t box, float* place) const {
    const DeviceVertex& vertex = launch_.plan.vertices[patch_.Vertex(c)];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      place[i] = static_cast<float>(LocalCoordinate(launch_, vertex, box, i));
    }
  }
  // The box that owns the first corner, or the inner points of its edge; `turn`: which one that is in
  // the plan.
  __device__ __forceinline__ uint32_t OwnerOfCorner(int turn) const {
    return OwnerOf(launch_, {index_, box(), static_cast<uint32_t>(turn), patch_.CornerSteps(turn),
                             patch_.CornerOnSeam(turn)});
  }
  __device__ __forceinline__ uint32_t OwnerOfEdge(int turn) const {
    return OwnerOf(launch_, {index_, box(), static_cast<uint32_t>(turn) + 3, patch_.EdgeSteps(0),
                             patch_.EdgeOnSeam(0)});
  }
  // The next corner comes first: registers have no index.
  __device__ __forceinline__ void Turn() {
    const DirectCorner first = corner_[0];
    corner_[0] = corner_[1], corner_[1] = corner_[2], corner_[2] = first;
    const uint32_t word = patch_.word[0];
    patch_.word[0] = patch_.word[1], patch_.word[1] = patch_.word[2], patch_.word[2] = word;
  }

 private:
  // Of the facet normal, the same thrice.
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
  DevicePatch patch_;
  const PackedDirection facet_;
  double per_unit_;
  DirectCorner corner_[3];
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_DIRECT_PATCH_CUH_
