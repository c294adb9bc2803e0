// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan on the device, as the kernels of one pipeline read it.
//
//   a patch   16 bytes of indices, 8 of facet normal, 36 more once a smooth view exists
//   a vertex  48 bytes, about half a vertex a patch
//   fused     knot boxes, feature uses: fused_tables.h
//   weights   8 bytes a vertex, 24 a patch and a control point, 96 a knot box, where the plan has any
//   others    shared points: shared_point_tables.h
//
// Errors   those of device_buffer.h
// Threads  safe; usable on every stream once it is made
#ifndef LATTICED_CUDA_PLAN_DEVICE_PLAN_H_
#define LATTICED_CUDA_PLAN_DEVICE_PLAN_H_

#include <memory>

#include "core/backend.h"
#include "core/base/mutex.h"
#include "core/ffd/plan/deform_plan.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/device/table_upload.h"
#include "cuda/plan/chunk_needs.h"
#include "cuda/plan/fused_tables.h"
#include "cuda/plan/plan_tables.h"
#include "cuda/plan/shared_point_tables.h"
#include "cuda/plan/turned_tables.h"

namespace latticed {

class DevicePlan {
 public:
  // Waits for the context's stream.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<DevicePlan>> Create(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
      std::shared_ptr<CudaContext> context);

  // corner_normals is null in these.
  const kernels::PlanTables& tables() const { return tables_; }
  // The first `smooth` call uploads the corner normals, into reserved bytes, and waits for the
  // upload. Two concurrent calls may both upload them; one copy is kept.
  [[nodiscard]] absl::StatusOr<kernels::PlanTables> Tables(bool smooth, DeviceReservation& from);
  // The bytes that Tables will allocate; 0 where it has allocated them.
  uint64_t BytesToCome(bool smooth) const;
  // Not for kFused.
  const kernels::SharedPointTables& shared_points() const { return shared_points_; }
  const kernels::TurnedTables& turned() const { return turned_; }
  // For kFused alone.
  const kernels::FusedTables& fused_tables() const { return fused_tables_; }
  // For kFused with a large lattice; else null.
  const std::shared_ptr<const ChunkNeeds>& chunk_needs() const { return chunk_needs_; }
  size_t MemoryBytes() const;  // on the device
  size_t HostMemoryBytes() const;

 private:
  DevicePlan(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaContext> context)
      : plan_(std::move(plan)), context_(std::move(context)) {}
  absl::Status AddTables(Pipeline pipeline, TableUpload& upload);
  [[nodiscard]] absl::StatusOr<DeviceBuffer<kernels::CornerNormals>> UploadNormals(
      DeviceReservation& from) const;
  // Null until they are uploaded.
  const kernels::CornerNormals* CornerNormalsNow() const;

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<CudaContext> context_;
  DeviceBuffer<uint8_t> block_;  // holds all tables but the corner normals
  kernels::PlanTables tables_{};
  kernels::FusedTables fused_tables_{};
  kernels::SharedPointTables shared_points_{};
  kernels::TurnedTables turned_{};
  std::shared_ptr<const ChunkNeeds> chunk_needs_;
  mutable Mutex mutex_;
  DeviceBuffer<kernels::CornerNormals> corner_normals_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_DEVICE_PLAN_H_
