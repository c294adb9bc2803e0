// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tables of a plan in device memory, as all kernels read them.
//
// Units    world units relative to plan.local_origin
#ifndef LATTICED_CUDA_PLAN_PLAN_TABLES_H_
#define LATTICED_CUDA_PLAN_PLAN_TABLES_H_

#include <cstddef>
#include <cstdint>

#include "core/base/vec.h"
#include "cuda/plan/device_patch.h"
#include "cuda/plan/packed_direction.h"
#include "cuda/plan/weight_tables.h"

namespace latticed::kernels {

struct alignas(16) DeviceVertex {  // read 16 bytes at a time
  Vec3d parameter;
  Vec3d world;  // relative to the local origin
};
struct DeviceBox {
  int span[4];  // of u, v, w; the fourth fills 16 bytes
};
// The interpolated vertex normal at the corners of a patch; linear between them.
struct CornerNormals {
  Vec3f corner[3];
};

// A plan as kernels read it.
struct PlanTables {
  int degree[3];
  int size[3];
  const double* knots[3];
  Vec3d parameter_by_world[3];  // columns d(u, v, w) / d(x, y, z)
  uint32_t outside_box;
  const DevicePatch* patches;
  const DeviceVertex* vertices;
  const DeviceBox* boxes;
  const PackedDirection* facet_normals;  // of the source triangle, one a patch
  const CornerNormals* corner_normals;   // null until a smooth view asks
  WeightTables weights;
};

enum class Normals { kNone, kFacet, kSmooth };

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_PLAN_TABLES_H_
