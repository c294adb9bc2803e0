// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of meshes with weights, each by itself and in double, from the definition (core/ffd/weights/vertex_weights.h):
//
//   position   x + w (F(x) - x); of a point on the rim from its corner or edge alone, so that neighbours agree
//   normal     cof(J) N / |...|, J = I + w (J_F - I) + (F(x) - x) grad(w)^T of the patch's own box
//
// The kernels of meshes without weights have not changed for this one. It takes longer than they do: it computes in double,
// and shares nothing between points.
//
// A block takes a chunk, a lane a patch, and the warps of a block take the points in turn.
#include "core/ffd/tessellation_pattern.h"
#include "cuda/fused/fused_geometry.cuh"
#include "cuda/fused/fused_store.cuh"
#include "cuda/fused/weighted_launch.h"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {
namespace {

constexpr int kWeightedWarps = 4, kWeightedThreads = kWeightedWarps * kLanes;

// A point of the mesh at rest.
struct RestPlace {
  Vec3d world;  // relative to the local origin
  Vec3d parameter;
  double weight;
};

class WeightedPatch {
 public:
  __device__ WeightedPatch(const WeightedLaunch& launch, uint32_t index)
      : launch_(launch.fused),
        gradient_(launch.weights.gradients[index]),
        index_(index),
        patch_(launch.fused.plan.patches[index]) {
    for (int c = 0; c < 3; ++c) {
      const uint32_t v = patch_.Vertex(c);
      const DeviceVertex& vertex = launch_.plan.vertices[v];
      corner_[c] = {vertex.world, vertex.parameter, launch.weights.vertices[v]};
    }
  }

  // Relative to the local origin.
  __device__ Vec3d Position(const int (&steps)[3]) const {
    const int s = launch_.segments;
    for (int c = 0; c < 3; ++c) {
      if (steps[c] == s) return Blended(corner_[c], OwnerOfCorner(c));
    }
    for (int e = 0; e < 3; ++e) {
      if (steps[(e + 2) % 3] != 0) continue;
      return Blended(OnEdge(corner_[e], corner_[(e + 1) % 3], steps[(e + 1) % 3]), OwnerOfEdge(e));
    }
    return Blended(Inside(Barycentrics(steps)), patch_.Box());
  }

  __device__ Vec3d Normal(const int (&steps)[3]) const {
    const bool smooth = launch_.normals == Normals::kSmooth;
    const CarriedNormal here = Carried(Barycentrics(steps), smooth);
    if (here.kappa <= kMaxNormalCondition) return here.direction;
    const Vec3d centroid{1.0 / 3, 1.0 / 3, 1.0 / 3};
    const CarriedNormal middle = Carried(centroid, smooth);
    if (middle.kappa <= kMaxNormalCondition) return middle.direction;
    const Vec3d rest = Unit(RestNormal(launch_.plan, index_, centroid, smooth));
    return rest != Vec3d{} ? rest : UnpackDirection(launch_.plan.facet_normals[index_]);
  }

 private:
  __device__ Vec3d Barycentrics(const int (&steps)[3]) const {
    const double over = 1.0 / launch_.segments;
    return {steps[0] * over, steps[1] * over, steps[2] * over};
  }
  __device__ RestPlace Inside(Vec3d b) const {
    return {b.x * corner_[0].world + b.y * corner_[1].world + b.z * corner_[2].world,
            b.x * corner_[0].parameter + b.y * corner_[1].parameter + b.z * corner_[2].parameter,
            b.x * corner_[0].weight + b.y * corner_[1].weight + b.z * corner_[2].weight};
  }
  // The k-th of segments + 1 points. Exchanging the ends changes only the signs of tau and of the differences.
  __device__ RestPlace OnEdge(const RestPlace& from, const RestPlace& to, int k) const {
    const double tau = (2 * k - launch_.segments) * (0.5 / launch_.segments);
    return {0.5 * (from.world + to.world) + tau * (to.world - from.world),
            0.5 * (from.parameter + to.parameter) + tau * (to.parameter - from.parameter),
            0.5 * (from.weight + to.weight) + tau * (to.weight - from.weight)};
  }

  __device__ uint32_t OwnerOfCorner(int c) const {
    return OwnerOf(launch_, {index_, patch_.Box(), static_cast<uint32_t>(c), patch_.CornerSteps(c),
                             patch_.CornerOnSeam(c)});
  }
  __device__ uint32_t OwnerOfEdge(int e) const {
    return OwnerOf(launch_, {index_, patch_.Box(), static_cast<uint32_t>(e) + 3,
                             patch_.EdgeSteps(e), patch_.EdgeOnSeam(e)});
  }

  // x + w (F(x) - x), with F of the box.
  __device__ Vec3d Blended(const RestPlace& at, uint32_t box) const {
    if (box == launch_.plan.outside_box) return at.world;
    const Vec3d deformed = EvaluateVolume<false>(Volume(launch_.plan, launch_.control_points),
                                                 launch_.plan.boxes[box].span, at.parameter)
                               .position;
    return at.world + at.weight * (deformed - at.world);
  }

  __device__ CarriedNormal Carried(Vec3d b, bool smooth) const {
    Vec3d jacobian[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (patch_.Box() != launch_.plan.outside_box) {
      const RestPlace at = Inside(b);
      const VolumePoint point =
          EvaluateVolume<true>(Volume(launch_.plan, launch_.control_points),
                               launch_.plan.boxes[patch_.Box()].span, at.parameter);
      WorldJacobian(point.derivatives, launch_.plan.parameter_by_world, jacobian);
      const Vec3d offset = point.position - at.world;
      const double rest = 1 - at.weight;
      jacobian[0] = at.weight * jacobian[0] + gradient_.x * offset + Vec3d{rest, 0, 0};
      jacobian[1] = at.weight * jacobian[1] + gradient_.y * offset + Vec3d{0, rest, 0};
      jacobian[2] = at.weight * jacobian[2] + gradient_.z * offset + Vec3d{0, 0, rest};
    }
    return CarryNormal(jacobian, RestNormal(launch_.plan, index_, b, smooth));
  }

  const FusedLaunch& launch_;
  const Vec3d gradient_;
  const uint32_t index_;
  const DevicePatch patch_;
  RestPlace corner_[3];
};

template <bool kFloat>
__device__ void StorePoint(const WeightedLaunch& launch, const WeightedPatch& patch,
                           const VertexSink<kFloat>& sink, int row, int column) {
  const FusedLaunch& fused = launch.fused;
  const int steps[3] = {fused.segments - row - column, column, row};
  const Vec3d p = fused.polynomials.scale * patch.Position(steps) + fused.polynomials.offset;
  Vec3d n{0, 0, 1};
  if (fused.normals != Normals::kNone) n = patch.Normal(steps);
  const float3 normal{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  const float norm1 = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
  using Vertex = typename VertexSink<kFloat>::Vertex;
  const unsigned places[1] = {sink.Place(PointIndex(fused.segments, row, column))};
  const Vertex vertices[1] = {
      sink.MakeVertex(sink.MakePosition({static_cast<float>(p.x), static_cast<float>(p.y),
                                         static_cast<float>(p.z)}),
                      normal, norm1, 1.0f)};
  sink.Store(places, vertices);
}

template <bool kFloat>
__global__ void __launch_bounds__(kWeightedThreads)
    WeightedKernel(const __grid_constant__ WeightedLaunch launch) {
  const FusedLaunch& fused = launch.fused;
  const uint32_t chunk = fused.chunks != nullptr ? fused.chunks[blockIdx.x] : blockIdx.x;
  const unsigned lane = threadIdx.x % kLanes;
  const int warp = static_cast<int>(threadIdx.x / kLanes);
  const uint32_t index = chunk * kLanes + lane;
  if (index >= fused.patch_count) return;
  const WeightedPatch patch(launch, index);
  const VertexSink<kFloat> sink(fused, chunk, lane);
  int point = 0;
  for (int row = 0; row <= fused.segments; ++row) {
    for (int column = 0; column <= fused.segments - row; ++column, ++point) {
      if (point % kWeightedWarps == warp) StorePoint<kFloat>(launch, patch, sink, row, column);
    }
  }
}

}  // namespace

KernelCall WeightedCall(const WeightedLaunch& launch) {
  const unsigned blocks = launch.fused.chunk_count;
  return launch.fused.output.format == LaneFormat::kFloat32
             ? KernelCall(&WeightedKernel<true>, Order::kAfter, blocks, kWeightedThreads, 0, launch)
             : KernelCall(&WeightedKernel<false>, Order::kAfter, blocks, kWeightedThreads, 0,
                          launch);
}

}  // namespace latticed::kernels
