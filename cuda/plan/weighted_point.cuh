// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of the mesh at rest, with their weights (core/ffd/weights/vertex_weights.h). The plan must be weighted.
#ifndef LATTICED_CUDA_PLAN_WEIGHTED_POINT_CUH_
#define LATTICED_CUDA_PLAN_WEIGHTED_POINT_CUH_

#include "cuda/plan/plan_tables.h"

namespace latticed::kernels {

__device__ inline Vec3d Blend(const Vec3d* corner, Vec3d b) {
  return b.x * corner[0] + b.y * corner[1] + b.z * corner[2];
}

struct WeightedPoint {
  Vec3d rest;
  double weight;

  // `deformed`: F of the point.
  __device__ Vec3d Weigh(Vec3d deformed) const { return rest + weight * (deformed - rest); }
};

// At barycentrics b of a patch.
__device__ inline WeightedPoint WeightedOfPatch(const PlanTables& plan, size_t patch, Vec3d b) {
  Vec3d world[3];
  double weight = 0;
  for (int c = 0; c < 3; ++c) {
    const uint32_t v = plan.patches[patch].Vertex(c);
    world[c] = plan.vertices[v].world;
    weight += (&b.x)[c] * plan.weights.vertices[v];
  }
  return {Blend(world, b), weight};
}

// At the place t from vertex a to vertex b.
__device__ inline WeightedPoint WeightedOnEdge(const PlanTables& plan, uint32_t a, uint32_t b,
                                               double t) {
  const double* weights = plan.weights.vertices;
  return {(1 - t) * plan.vertices[a].world + t * plan.vertices[b].world,
          (1 - t) * weights[a] + t * weights[b]};
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_WEIGHTED_POINT_CUH_
