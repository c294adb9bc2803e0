// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The normal of the definition at one point, in double, for points where products in float32 cancel. It
// has the formulas of DirectFfd::Evaluate (core/ffd/carried_normal.h, core/ffd/weights/vertex_weights.h)
// and reads the device's tables.
#ifndef LATTICED_CUDA_PLAN_DEFINITION_NORMAL_CUH_
#define LATTICED_CUDA_PLAN_DEFINITION_NORMAL_CUH_

#include "core/ffd/carried_normal.h"
#include "cuda/plan/turned_moves.cuh"
#include "cuda/plan/volume.cuh"

namespace latticed::kernels {

__device__ inline Vec3d Blend(const Vec3d* corner, Vec3d b) {
  return b.x * corner[0] + b.y * corner[1] + b.z * corner[2];
}

// The interpolated vertex normal, not normalised.
__device__ inline Vec3d RestSmoothNormal(const PlanTables& plan, size_t patch, Vec3d b) {
  Vec3d corner[3];
  for (int c = 0; c < 3; ++c) corner[c] = ToDouble(plan.corner_normals[patch].corner[c]);
  return Blend(corner, b);
}

__device__ inline Vec3d RestNormal(const PlanTables& plan, size_t patch, Vec3d b, bool smooth) {
  return smooth ? RestSmoothNormal(plan, patch, b) : UnpackDirection(plan.facet_normals[patch]);
}

// With weights, from the Jacobian of F to I + w (J_F - I) + (F(x) - x) grad(w)^T. `deformed`: F(x).
__device__ inline void Weigh(const PlanTables& plan, size_t patch, Vec3d b, Vec3d deformed,
                             Vec3d (&jacobian)[3]) {
  Vec3d world[3];
  double weight = 0;
  for (int c = 0; c < 3; ++c) {
    const uint32_t v = plan.patches[patch].Vertex(c);
    world[c] = plan.vertices[v].world;
    weight += (&b.x)[c] * plan.weights.vertices[v];
  }
  const Vec3d gradient = plan.weights.gradients[patch], offset = deformed - Blend(world, b);
#pragma unroll
  for (int axis = 0; axis < 3; ++axis) {
    jacobian[axis] = weight * jacobian[axis] + (&gradient.x)[axis] * offset;
    jacobian[axis][axis] += 1 - weight;
  }
}

// A plan without turned lattices.
struct NoTurned {
  __device__ void AddTo(const PlanTables&, const Vec3d*, size_t, Vec3d, Vec3d*) const {}
};
struct Turned {
  const TurnedTables& tables;

  __device__ void AddTo(const PlanTables& plan, const Vec3d* control_points, size_t patch, Vec3d b,
                        Vec3d* jacobian) const {
    Vec3d position;
    AddTurned<true>(plan, tables, control_points, patch, b, position, jacobian);
  }
};

// Not inlined, because kernels with many instances call it twice.
template <class TurnedOrNot>
__device__ __noinline__ CarriedNormal CarryAt(const PlanTables& plan, const Vec3d* control_points,
                                              size_t patch, Vec3d b, bool smooth,
                                              const TurnedOrNot& turned) {
  const DevicePatch p = plan.patches[patch];
  Vec3d jacobian[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (p.Box() != plan.outside_box) {
    Vec3d parameter[3];
    for (int c = 0; c < 3; ++c) parameter[c] = plan.vertices[p.Vertex(c)].parameter;
    const VolumePoint point = EvaluateVolume<true>(Volume(plan, control_points),
                                                   plan.boxes[p.Box()].span, Blend(parameter, b));
    WorldJacobian(point.derivatives, plan.parameter_by_world, jacobian);
    if (plan.weights.vertices != nullptr) Weigh(plan, patch, b, point.position, jacobian);
  }
  turned.AddTo(plan, control_points, patch, b, jacobian);
  return CarryNormal(jacobian, RestNormal(plan, patch, b, smooth));
}

template <class TurnedOrNot = NoTurned>
__device__ Vec3d DefinitionNormal(const PlanTables& plan, const Vec3d* control_points, size_t patch,
                                  Vec3d b, bool smooth, const TurnedOrNot& turned = {}) {
  const Vec3d centroid{1.0 / 3, 1.0 / 3, 1.0 / 3};
  const CarriedNormal here = CarryAt(plan, control_points, patch, b, smooth, turned);
  if (here.kappa <= kMaxNormalCondition) return here.direction;
  const CarriedNormal middle = CarryAt(plan, control_points, patch, centroid, smooth, turned);
  if (middle.kappa <= kMaxNormalCondition) return middle.direction;
  const Vec3d rest = Unit(RestNormal(plan, patch, centroid, smooth));
  return rest != Vec3d{} ? rest : UnpackDirection(plan.facet_normals[patch]);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_DEFINITION_NORMAL_CUH_
