// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The weights of a plan in device memory (core/ffd/weights/vertex_weights.h), beside PlanTables.
#ifndef LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_
#define LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_

#include "core/base/vec.h"

namespace latticed::kernels {

// Both are null without weights.
struct WeightTables {
  const double* vertices;  // one a vertex
  const Vec3d* gradients;  // one a patch, by world position
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_WEIGHT_TABLES_H_
