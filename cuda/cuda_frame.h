// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What changes from one evaluation to the next, brought to the device by one copy of a few KB: the
// control points relative to the plan's local origin, and which seams are attached.
//
// Errors   those of device_buffer.h and pinned_memory.h
// Threads  one at a time; Upload enqueues, and waits only for its own last copy
#ifndef LATTICED_CUDA_CUDA_FRAME_H_
#define LATTICED_CUDA_CUDA_FRAME_H_

#include <memory>
#include <span>

#include "core/ffd/deform_plan.h"
#include "cuda/cuda_context.h"
#include "cuda/device_buffer.h"

namespace latticed {

class CudaFrame {
 public:
  // Copies on the stream of `lane`.
  [[nodiscard]] static absl::StatusOr<CudaFrame> Create(std::shared_ptr<const DeformPlan> plan,
                                                        CudaContext& context,
                                                        std::shared_ptr<CudaLane> lane);
  ~CudaFrame();
  CudaFrame(CudaFrame&&) = default;
  CudaFrame& operator=(CudaFrame&&) = delete;

  [[nodiscard]] absl::Status Upload(std::span<const Vec3d> control_points);

  DeviceSpan<const Vec3d> control_points() const;
  DeviceSpan<const uint8_t> attached() const;  // 1 or 0, per seam of the plan
  size_t DeviceBytes() const { return device_.size_bytes(); }
  size_t PinnedBytes() const { return pinned_.size(); }

 private:
  CudaFrame(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaLane> lane,
            DeviceBuffer<uint8_t> device, PinnedBuffer pinned, CudaEvent copied)
      : plan_(std::move(plan)),
        lane_(std::move(lane)),
        device_(std::move(device)),
        pinned_(std::move(pinned)),
        copied_(std::move(copied)) {}
  size_t points() const { return static_cast<size_t>(plan_->structure.control_point_count()); }

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint8_t> device_;  // control points, then seams
  PinnedBuffer pinned_;           // the same
  CudaEvent copied_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_FRAME_H_
