// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lanes: streams with their cuBLAS handles. Each view borrows one and then returns it for the next
// view of the same priority, because making a handle takes longer than a frame. Only a few idle
// lanes keep their handle, since each handle has a workspace that counts against the budget.
//
// Errors   those of cuda_status.h; kResourceExhausted for the handle's workspace
// Threads  CudaLanes is safe; a CudaLane is used by one thread at a time
#ifndef LATTICED_CUDA_DEVICE_CUDA_LANES_H_
#define LATTICED_CUDA_DEVICE_CUDA_LANES_H_

#include <functional>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/cuda_gemm.h"

namespace latticed {

class CudaLane {
 public:
  CudaLane(StreamPriority priority, CudaStream stream)
      : priority_(priority), stream_(std::move(stream)) {}

  StreamPriority priority() const { return priority_; }
  const CudaStream& stream() const { return stream_; }
  // Made at its first use, which takes GemmBytesToCome from the reservation. The fused pipeline
  // never asks for it.
  [[nodiscard]] absl::StatusOr<CudaGemm*> gemm(DeviceReservation& from);
  // The bytes that gemm will allocate; 0 once it exists.
  uint64_t GemmBytesToCome() const { return has_gemm() ? 0 : CudaGemm::kWorkspaceBytes; }
  bool has_gemm() const { return gemm_ != nullptr; }
  // Waits for the device, as cublasDestroy does.
  void DropGemm() { gemm_.reset(); }

  // For measurements: called on the host with the name of each stage of an evaluation, after the
  // stage's work is enqueued.
  using StageMark = std::function<void(std::string_view stage)>;
  void set_stage_mark(StageMark mark) { stage_mark_ = std::move(mark); }
  void Enqueued(std::string_view stage) const {
    if (stage_mark_) stage_mark_(stage);
  }
  bool marks_stages() const { return static_cast<bool>(stage_mark_); }

 private:
  const StreamPriority priority_;
  CudaStream stream_;  // declared first: the workspace is freed on it
  std::unique_ptr<CudaGemm> gemm_;
  StageMark stage_mark_;
};

class CudaLanes : public std::enable_shared_from_this<CudaLanes> {
 public:
  explicit CudaLanes(std::shared_ptr<DeviceMemory> memory) : memory_(std::move(memory)) {}

  // A lane of the current device. Its stream may still hold work of the last borrower.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<CudaLane>> Borrow(
      StreamPriority priority = StreamPriority::kLeast);

 private:
  void Return(std::unique_ptr<CudaLane> lane);

  std::shared_ptr<DeviceMemory> memory_;
  Mutex mutex_;
  std::vector<std::unique_ptr<CudaLane>> free_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_LANES_H_
