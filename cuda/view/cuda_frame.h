// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The input of an evaluation, brought to the device in one copy: the control points relative to the
// plan's local origin, the attached seams, and the chunks to evaluate. Where the frame names few
// chunks of a large lattice, it copies only the control points that they need, and the list of
// their boxes.
//
//   | control points | seams | chunks | boxes |      the first in pages: lattice_part.h
//
// Errors   those of staged_upload.h
// Threads  one at a time; Send and Sent enqueue, Stage and Upload wait for the last Sent
#ifndef LATTICED_CUDA_VIEW_CUDA_FRAME_H_
#define LATTICED_CUDA_VIEW_CUDA_FRAME_H_

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/device/staged_upload.h"
#include "cuda/plan/lattice_part.h"

namespace latticed {

class CudaFrame {
 public:
  // Copies on the stream of `lane`. Takes DeviceBytesFor from the reservation. `chunk_needs`: what
  // each chunk needs of a large lattice, for kernels that read only this; else null.
  [[nodiscard]] static absl::StatusOr<CudaFrame> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<const ChunkNeeds> chunk_needs,
      CudaContext& context, std::shared_ptr<CudaLane> lane, DeviceReservation& from);
  static size_t DeviceBytesFor(const DeformPlan& plan, bool has_chunk_needs);
  static size_t PinnedBytesFor(const DeformPlan& plan, bool has_chunk_needs);

  // Prepares the next copy and enqueues nothing. Then call Send or SendCall once and Sent after it,
  // also if the launch of the kernels that read the copy fails.
  [[nodiscard]] absl::Status Stage(std::span<const Vec3d> control_points,
                                   std::span<const uint32_t> chunks);
  [[nodiscard]] absl::Status Send() const { return upload_.Send(SendCall()); }
  kernels::KernelCall SendCall() const;
  [[nodiscard]] absl::Status Sent() const { return upload_.Sent(); }
  // Stage, Send and Sent, for kernels that read no list of chunks.
  [[nodiscard]] absl::Status Upload(std::span<const Vec3d> control_points);

  DeviceSpan<const Vec3d> control_points() const;
  // For each seam of the plan: 1 if it is attached, else 0. Where boxes() is a list, only the seams
  // of the named chunks are valid.
  DeviceSpan<const uint8_t> attached() const;
  // The named chunks; null for all chunks of the plan.
  const uint32_t* chunks() const { return all_chunks_ ? nullptr : ListAt(ChunksAt()); }
  // The knot boxes whose control points are copied. Null data means all boxes.
  DeviceSpan<const uint32_t> boxes() const;
  size_t DeviceBytes() const { return upload_.DeviceBytes(); }
  size_t PinnedBytes() const { return upload_.PinnedBytes(); }

 private:
  CudaFrame(std::shared_ptr<const DeformPlan> plan, std::optional<LatticePart> part,
            StagedUpload upload)
      : plan_(std::move(plan)), part_(std::move(part)), upload_(std::move(upload)) {}
  size_t points() const { return plan_->control_point_count(); }
  // Offsets in upload_.
  size_t SeamsAt() const;
  size_t ChunksAt() const;
  const uint32_t* ListAt(size_t place) const {
    return reinterpret_cast<const uint32_t*>(upload_.device_data() + place);
  }
  void StagePoints(std::span<const Vec3d> control_points, size_t first, size_t last,
                   uint8_t* staged) const;
  void StageSeams(std::span<const Vec3d> control_points, uint8_t* staged) const;

  std::shared_ptr<const DeformPlan> plan_;
  std::optional<LatticePart> part_;  // for large lattices and kernels with chunk_needs
  StagedUpload upload_;
  // Set by Stage.
  size_t bytes_ = 0, boxes_at_ = 0;
  bool all_chunks_ = true, only_part_ = false;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_CUDA_FRAME_H_
