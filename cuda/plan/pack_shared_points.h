// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Packs the tables of core/ffd/plan/shared_points.h for the device, in about 10 bytes a patch.
//
//   a vertex  4 bytes: the use that owns its position
//   an edge   5 bytes for each of its uses but the owner; 4 for each run of 32 patches, where its copies begin
//   on seams, and for positions without an owner: one record each
//
// Threads  pure
#ifndef LATTICED_CUDA_PLAN_PACK_SHARED_POINTS_H_
#define LATTICED_CUDA_PLAN_PACK_SHARED_POINTS_H_

#include <cstdint>
#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/plan/shared_point_tables.h"

namespace latticed {

struct PackedSharedPoints {
  std::vector<kernels::PackedUse> vertex_owners;
  std::vector<uint32_t> edge_begins;
  std::vector<kernels::PackedUse> edge_owners;
  std::vector<uint8_t> edge_uses;
  std::vector<kernels::DeviceSeamCopy> on_seams;
  std::vector<kernels::DeviceOrphan> orphans;
};
[[nodiscard]] PackedSharedPoints PackSharedPoints(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_PACK_SHARED_POINTS_H_
