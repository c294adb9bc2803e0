// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The lattices of a plan that are turned against its own (core/ffd/turned/turned_lattice.h), in device memory.
//
// Units    control points are relative to plan.local_origin
#ifndef LATTICED_CUDA_PLAN_TURNED_TABLES_H_
#define LATTICED_CUDA_PLAN_TURNED_TABLES_H_

#include <cstddef>

#include "core/base/limits.h"
#include "core/base/vec.h"
#include "cuda/plan/plan_tables.h"

namespace latticed::kernels {

struct TurnedTable {
  int degree[3];
  int size[3];
  const double* knots[3];
  size_t first_point;           // among the control points of the plan
  Vec3d parameter_by_world[3];  // columns d(u, v, w) / d(x, y, z)
  const Vec3d* parameters;      // by vertex of the plan
  const DeviceBox* spans;       // by patch; below 0 outside the frame
};

struct TurnedTables {
  int count;
  TurnedTable lattices[limits::kMaxLattices - 1];
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_TURNED_TABLES_H_
