// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Normals of meshes with weights from the definition, in double (core/ffd/weights/vertex_weights.h): for points where products
// in float32 cancel.
//
//   cof(J) N / |...|,  J = I + w (J_F - I) + (F(x) - x) grad(w)^T of the patch's own box
#ifndef LATTICED_CUDA_FUSED_WEIGHTED_NORMAL_CUH_
#define LATTICED_CUDA_FUSED_WEIGHTED_NORMAL_CUH_

#include "cuda/fused/weighted_launch.h"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {

// `b`: barycentric coordinates. Not inlined, because it is called twice.
__device__ __noinline__ inline CarriedNormal CarryWeightedAt(const WeightedLaunch& launch,
                                                             uint32_t index, Vec3d b) {
  const PlanTables& plan = launch.fused.plan;
  const DevicePatch patch = plan.patches[index];
  Vec3d jacobian[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (patch.Box() != plan.outside_box) {
    Vec3d world[3], parameter[3];
    double weight = 0;
    for (int c = 0; c < 3; ++c) {
      const uint32_t v = patch.Vertex(c);
      world[c] = plan.vertices[v].world;
      parameter[c] = plan.vertices[v].parameter;
      weight += (&b.x)[c] * launch.weights.vertices[v];
    }
    const VolumePoint point =
        EvaluateVolume<true>(Volume(plan, launch.fused.control_points),
                             plan.boxes[patch.Box()].span, Blend(parameter, b));
    WorldJacobian(point.derivatives, plan.parameter_by_world, jacobian);
    const Vec3d gradient = launch.weights.gradients[index],
                offset = point.position - Blend(world, b);
    const double rest = 1 - weight;
    jacobian[0] = weight * jacobian[0] + gradient.x * offset + Vec3d{rest, 0, 0};
    jacobian[1] = weight * jacobian[1] + gradient.y * offset + Vec3d{0, rest, 0};
    jacobian[2] = weight * jacobian[2] + gradient.z * offset + Vec3d{0, 0, rest};
  }
  return CarryNormal(jacobian,
                     RestNormal(plan, index, b, launch.fused.normals == Normals::kSmooth));
}

__device__ inline Vec3d WeightedNormal(const WeightedLaunch& launch, uint32_t index, Vec3d b) {
  const CarriedNormal here = CarryWeightedAt(launch, index, b);
  if (here.kappa <= kMaxNormalCondition) return here.direction;
  const Vec3d centroid{1.0 / 3, 1.0 / 3, 1.0 / 3};
  const CarriedNormal middle = CarryWeightedAt(launch, index, centroid);
  if (middle.kappa <= kMaxNormalCondition) return middle.direction;
  const PlanTables& plan = launch.fused.plan;
  const Vec3d rest =
      Unit(RestNormal(plan, index, centroid, launch.fused.normals == Normals::kSmooth));
  return rest != Vec3d{} ? rest : UnpackDirection(plan.facet_normals[index]);
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEIGHTED_NORMAL_CUH_
