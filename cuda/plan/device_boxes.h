// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the fused kernels read of a plan besides device_plan.h: its knot boxes, and who shares points
// in a chunk.
//
//   a patch      8 bytes: feature_uses.h
//   a box        120 bytes
//   a knot span  128 bytes: the matrix of core/ffd/box_basis.h
//   a corner or edge on a seam  8 bytes
//
// Errors   those of device_buffer.h
// Threads  immutable; usable on every stream once the one it was uploaded on has passed
#ifndef LATTICED_CUDA_PLAN_DEVICE_BOXES_H_
#define LATTICED_CUDA_PLAN_DEVICE_BOXES_H_

#include <memory>
#include <vector>

#include "core/ffd/deform_plan.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/plan/fused_tables.h"

namespace latticed {

class DeviceBoxes {
 public:
  // Enqueues its uploads on the context's stream.
  [[nodiscard]] static absl::StatusOr<DeviceBoxes> Create(
      const std::shared_ptr<const DeformPlan>& plan, CudaContext& context,
      const std::vector<kernels::SeamUse>& seam_uses);

  const kernels::FusedTables& tables() const { return tables_; }
  size_t MemoryBytes() const {
    return boxes_.size_bytes() + basis_.size_bytes() + seam_uses_.size_bytes() +
           feature_uses_.size_bytes();
  }

 private:
  DeviceBoxes() = default;

  DeviceBuffer<kernels::FusedBox> boxes_;
  DeviceBuffer<double> basis_;  // by permuted axis and span
  DeviceBuffer<kernels::SeamUse> seam_uses_;
  DeviceBuffer<kernels::FeatureUses> feature_uses_;
  kernels::FusedTables tables_{};
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_DEVICE_BOXES_H_
