// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What pipelines that evaluate every patch by itself read of a plan besides device_plan.h: whose
// positions its corners and edges take. About 10 bytes a patch (pack_shared_points.h).
//
// Errors   those of device_buffer.h
// Threads  immutable; usable on every stream once the one it was uploaded on has passed
#ifndef LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_
#define LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_

#include "core/ffd/deform_plan.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/plan/shared_point_tables.h"

namespace latticed {

class DeviceSharedPoints {
 public:
  // Enqueues its uploads on the context's stream.
  [[nodiscard]] static absl::StatusOr<DeviceSharedPoints> Create(const DeformPlan& plan,
                                                                 CudaContext& context);

  const kernels::SharedPointTables& tables() const { return tables_; }
  size_t MemoryBytes() const {
    return vertex_owners_.size_bytes() + edge_begins_.size_bytes() + edge_owners_.size_bytes() +
           edge_uses_.size_bytes() + on_seams_.size_bytes() + orphans_.size_bytes();
  }

 private:
  DeviceSharedPoints() = default;

  DeviceBuffer<kernels::PackedUse> vertex_owners_, edge_owners_;
  DeviceBuffer<uint32_t> edge_begins_;
  DeviceBuffer<uint8_t> edge_uses_;
  DeviceBuffer<kernels::DeviceSeamCopy> on_seams_;
  DeviceBuffer<kernels::DeviceOrphan> orphans_;
  kernels::SharedPointTables tables_{};
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_DEVICE_SHARED_POINTS_H_
