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
#include "cuda/plan/weighted_point.cuh"

namespace latticed::kernels {

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
  const WeightedPoint point = WeightedOfPatch(plan, patch, b);
  const Vec3d gradient = plan.weights.gradients[patch], offset = deformed - point.rest;
#pragma unroll
  for (int axis = 0; axis < 3; ++axis) {
    jacobian[axis] = point.weight * jacobian[axis] + (&gradient.x)[axis] * offset;
    jacobian[axis][axis] += 1 - point.weight;
  }
}

// A plan without turned lattices.
struct NoTurned {
  static constexpr bool kAny = false;
};
struct Turned {
  static constexpr bool kAny = true;
  const TurnedTables& tables;

  __device__ void AddTo(const PlanTables& plan, const Vec3d* control_points, size_t patch, Vec3d b,
                        Vec3d& position, Vec3d* jacobian) const {
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
  [[maybe_unused]] Vec3d position;  // only with turned lattices and weights
  if (p.Box() != plan.outside_box) {
    Vec3d parameter[3];
    for (int c = 0; c < 3; ++c) parameter[c] = plan.vertices[p.Vertex(c)].parameter;
    const VolumePoint point = EvaluateVolume<true>(Volume(plan, control_points),
                                                   plan.boxes[p.Box()].span, Blend(parameter, b));
    WorldJacobian(point.derivatives, plan.parameter_by_world, jacobian);
    if constexpr (TurnedOrNot::kAny) {
      position = point.position;
    } else if (plan.weights.vertices != nullptr) {
      Weigh(plan, patch, b, point.position, jacobian);
    }
  } else if (TurnedOrNot::kAny && plan.weights.vertices != nullptr) {
    position = WeightedOfPatch(plan, patch, b).rest;
  }
  if constexpr (TurnedOrNot::kAny) {
    turned.AddTo(plan, control_points, patch, b, position, jacobian);
    if (plan.weights.vertices != nullptr) Weigh(plan, patch, b, position, jacobian);
  }
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
