// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The weights of a plan in device memory (core/ffd/weights/vertex_weights.h), a part of PlanTables.
#ifndef LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_
#define LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_

#include "core/base/vec.h"

namespace latticed::kernels {

// The points of a box at rest, x = centre + sum_i l_i by_coordinate[i], l its coordinates by permuted axis
// (fused_tables.h).
struct RestBox {
  Vec3d centre, by_coordinate[3];
};
// All are null without weights, and the last two in other pipelines than fused.
struct WeightTables {
  const double* vertices;        // one a vertex
  const Vec3d* gradients;        // one a patch, by world position
  const Vec3d* identity_points;  // the control points of the identity
  const RestBox* boxes;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_
