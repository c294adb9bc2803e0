// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an edit changes, on the device, in one copy: the control points relative to the plan's local
// origin, which seams are attached, and which chunks are to be evaluated.
//
// Errors   those of staged_upload.h
// Threads  one at a time; Send and Sent enqueue, Stage and Upload wait for the last Sent
#ifndef LATTICED_CUDA_VIEW_CUDA_FRAME_H_
#define LATTICED_CUDA_VIEW_CUDA_FRAME_H_

#include <memory>
#include <span>

#include "core/ffd/deform_plan.h"
#include "cuda/device/staged_upload.h"

namespace latticed {

class CudaFrame {
 public:
  // Copies on the stream of `lane`.
  [[nodiscard]] static absl::StatusOr<CudaFrame> Create(std::shared_ptr<const DeformPlan> plan,
                                                        CudaContext& context,
                                                        std::shared_ptr<CudaLane> lane);
  // The same, its memory on the device of bytes reserved: DeviceBytesFor.
  [[nodiscard]] static absl::StatusOr<CudaFrame> Create(std::shared_ptr<const DeformPlan> plan,
                                                        CudaContext& context,
                                                        std::shared_ptr<CudaLane> lane,
                                                        DeviceReservation& from);
  static size_t DeviceBytesFor(const DeformPlan& plan);

  // Takes what the next copy brings; nothing is enqueued. Then Send or SendCall, once, and then
  // Sent, whether the kernels that read it were launched or not.
  [[nodiscard]] absl::Status Stage(std::span<const Vec3d> control_points,
                                   std::span<const uint32_t> chunks);
  [[nodiscard]] absl::Status Send() const { return upload_.Send(bytes_); }
  kernels::KernelCall SendCall() const { return upload_.SendCall(bytes_); }
  [[nodiscard]] absl::Status Sent() const { return upload_.Sent(); }
  // All three, for kernels that read no list of chunks.
  [[nodiscard]] absl::Status Upload(std::span<const Vec3d> control_points);

  DeviceSpan<const Vec3d> control_points() const;
  DeviceSpan<const uint8_t> attached() const;  // 1 or 0, per seam of the plan
  // Null where all chunks of the plan were named.
  const uint32_t* chunks() const { return all_chunks_ ? nullptr : ChunkList(); }
  size_t DeviceBytes() const { return upload_.DeviceBytes(); }
  size_t PinnedBytes() const { return upload_.PinnedBytes(); }

 private:
  CudaFrame(std::shared_ptr<const DeformPlan> plan, StagedUpload upload)
      : plan_(std::move(plan)), upload_(std::move(upload)) {}
  size_t points() const { return static_cast<size_t>(plan_->structure.control_point_count()); }
  size_t ChunksAt() const;  // in upload_
  const uint32_t* ChunkList() const {
    return reinterpret_cast<const uint32_t*>(upload_.device_data() + ChunksAt());
  }

  std::shared_ptr<const DeformPlan> plan_;
  StagedUpload upload_;  // control points, then seams, then chunks
  size_t bytes_ = 0;     // staged
  bool all_chunks_ = true;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_CUDA_FRAME_H_
