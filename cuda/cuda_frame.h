// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an edit changes, on the device: the control points relative to the plan's local origin, and
// which seams are attached.
//
// Errors   those of staged_upload.h
// Threads  one at a time; Upload enqueues, and waits only for its own last copy
#ifndef LATTICED_CUDA_CUDA_FRAME_H_
#define LATTICED_CUDA_CUDA_FRAME_H_

#include <memory>
#include <span>

#include "core/ffd/deform_plan.h"
#include "cuda/staged_upload.h"

namespace latticed {

class CudaFrame {
 public:
  // Copies on the stream of `lane`.
  [[nodiscard]] static absl::StatusOr<CudaFrame> Create(std::shared_ptr<const DeformPlan> plan,
                                                        CudaContext& context,
                                                        std::shared_ptr<CudaLane> lane);

  [[nodiscard]] absl::Status Upload(std::span<const Vec3d> control_points);

  DeviceSpan<const Vec3d> control_points() const;
  DeviceSpan<const uint8_t> attached() const;  // 1 or 0, per seam of the plan
  size_t DeviceBytes() const { return upload_.DeviceBytes(); }
  size_t PinnedBytes() const { return upload_.PinnedBytes(); }

 private:
  CudaFrame(std::shared_ptr<const DeformPlan> plan, StagedUpload upload)
      : plan_(std::move(plan)), upload_(std::move(upload)) {}
  size_t points() const { return static_cast<size_t>(plan_->structure.control_point_count()); }

  std::shared_ptr<const DeformPlan> plan_;
  StagedUpload upload_;  // control points, then seams
};

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_FRAME_H_
