// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the turned lattices of a plan add to a point at rest. Twin of core/ffd/turned/turned_lattice.cc.
#ifndef LATTICED_CUDA_PLAN_TURNED_MOVES_CUH_
#define LATTICED_CUDA_PLAN_TURNED_MOVES_CUH_

#include "core/ffd/box/volume_point.h"
#include "core/ffd/bspline_basis.h"
#include "cuda/plan/plan_tables.h"
#include "cuda/plan/turned_tables.h"
#include "cuda/plan/volume.cuh"

namespace latticed::kernels {

// At barycentrics b of a patch: adds R_g(x) - x to `position`, and with kJacobian its derivatives to the columns of
// `jacobian`.
template <bool kJacobian>
__device__ inline void AddTurned(const PlanTables& plan, const TurnedTables& turned,
                                 const Vec3d* control_points, size_t patch, Vec3d b,
                                 Vec3d& position, Vec3d* jacobian) {
  const DevicePatch p = plan.patches[patch];
  const uint32_t v[3] = {p.Vertex(0), p.Vertex(1), p.Vertex(2)};
  for (int g = 0; g < turned.count; ++g) {
    const TurnedTable& lattice = turned.lattices[g];
    const int* span = lattice.spans[patch].span;
    if (span[0] < 0) continue;
    const Vec3d at = b.x * lattice.parameters[v[0]] + b.y * lattice.parameters[v[1]] +
                     b.z * lattice.parameters[v[2]];
    const Vec3d world = b.x * plan.vertices[v[0]].world + b.y * plan.vertices[v[1]].world +
                        b.z * plan.vertices[v[2]].world;
    const VolumePoint point =
        EvaluateVolume<kJacobian>(Volume(lattice, control_points + lattice.first_point), span, at);
    position += point.position - world;
    if constexpr (kJacobian) {
      Vec3d own[3];
      WorldJacobian(point.derivatives, lattice.parameter_by_world, own);
      for (int axis = 0; axis < 3; ++axis) {
        jacobian[axis] += own[axis];
        jacobian[axis][axis] -= 1;
      }
    }
  }
}

// At the place t from vertex a to vertex b, which are equal or joined by an edge.
__device__ inline Vec3d TurnedOnEdge(const PlanTables& plan, const TurnedTables& turned,
                                     const Vec3d* control_points, uint32_t a, uint32_t b,
                                     double t) {
  const Vec3d world = (1 - t) * plan.vertices[a].world + t * plan.vertices[b].world;
  Vec3d sum;
  for (int g = 0; g < turned.count; ++g) {
    const TurnedTable& lattice = turned.lattices[g];
    const Vec3d from = lattice.parameters[a], to = lattice.parameters[b];
    int span[3];
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      const double* knots = lattice.knots[axis];
      const int degree = lattice.degree[axis], size = lattice.size[axis];
      const double low = fmin(from[axis], to[axis]), high = fmax(from[axis], to[axis]);
      inside = inside && low >= knots[degree] && high <= knots[size];
      span[axis] = FindLowerSpan(knots, degree, size, high);
    }
    if (!inside) continue;
    sum += EvaluateVolume<false>(Volume(lattice, control_points + lattice.first_point), span,
                                 (1 - t) * from + t * to)
               .position -
           world;
  }
  return sum;
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_TURNED_MOVES_CUH_
