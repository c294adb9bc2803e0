// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of the surface in double, under all lattices of a plan and its weights. Twin of DirectFfd's positions
// (core/ffd/direct_ffd.h).
#ifndef LATTICED_CUDA_PLAN_PLAN_POINT_CUH_
#define LATTICED_CUDA_PLAN_PLAN_POINT_CUH_

#include "cuda/plan/turned_moves.cuh"
#include "cuda/plan/volume.cuh"
#include "cuda/plan/weighted_point.cuh"

namespace latticed::kernels {

// The point of a patch at barycentrics b.
__device__ inline Vec3d PlanPoint(const PlanTables& plan, const TurnedTables& turned,
                                  const Vec3d* control_points, size_t index, Vec3d b) {
  const DevicePatch patch = plan.patches[index];
  const bool outside = patch.Box() == plan.outside_box;
  Vec3d corner[3];
  for (int c = 0; c < 3; ++c) {
    const DeviceVertex& vertex = plan.vertices[patch.Vertex(c)];
    corner[c] = outside ? vertex.world : vertex.parameter;
  }
  Vec3d position = Blend(corner, b);
  if (!outside) {
    const int* span = plan.boxes[patch.Box()].span;
    position = EvaluateVolume<false>(Volume(plan, control_points), span, position).position;
  }
  AddTurned<false>(plan, turned, control_points, index, b, position, nullptr);
  if (plan.weights.vertices == nullptr) return position;
  return WeightedOfPatch(plan, index, b).Weigh(position);
}

// At the place t from vertex v0 to vertex v1, which are equal or joined by an edge, where the plan's own lattice has the
// polynomial of `box`. The outside box: its own lattice does not move it.
__device__ inline Vec3d PlanPointOnEdge(const PlanTables& plan, const TurnedTables& turned,
                                        const Vec3d* control_points, uint32_t box, uint32_t v0,
                                        uint32_t v1, double t) {
  const DeviceVertex &a = plan.vertices[v0], &b = plan.vertices[v1];
  Vec3d position = (1 - t) * a.world + t * b.world;
  if (box != plan.outside_box) {
    position = EvaluateVolume<false>(Volume(plan, control_points), plan.boxes[box].span,
                                     (1 - t) * a.parameter + t * b.parameter)
                   .position;
  }
  position += TurnedOnEdge(plan, turned, control_points, v0, v1, t);
  if (plan.weights.vertices == nullptr) return position;
  return WeightedOnEdge(plan, v0, v1, t).Weigh(position);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_PLAN_POINT_CUH_
