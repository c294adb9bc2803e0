// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_lanes.h"

#include <algorithm>

#include "core/base/status_macros.h"

namespace latticed {
namespace {

constexpr int kMostIdleHandles = 4;

}  // namespace

absl::StatusOr<CudaGemm*> CudaLane::gemm(DeviceReservation& from) {
  if (gemm_ == nullptr) {
    LATTICED_ASSIGN_OR_RETURN(gemm_, CudaGemm::Create(from, stream_.get()));
    from.LeaveBehind(CudaGemm::kWorkspaceBytes);
  }
  return gemm_.get();
}

absl::StatusOr<std::shared_ptr<CudaLane>> CudaLanes::Borrow(StreamPriority priority) {
  std::unique_ptr<CudaLane> lane;
  {
    const MutexLock lock(&mutex_);
    const auto found = std::ranges::find(free_, priority, &CudaLane::priority);
    if (found != free_.end()) {
      lane = std::move(*found);
      free_.erase(found);
    }
  }
  if (lane == nullptr) {
    LATTICED_ASSIGN_OR_RETURN(auto stream, CudaStream::Create(priority));
    lane = std::make_unique<CudaLane>(priority, std::move(stream));
  }
  // Each lane keeps the list alive.
  return std::shared_ptr<CudaLane>(lane.release(), [lanes = shared_from_this()](CudaLane* used) {
    lanes->Return(std::unique_ptr<CudaLane>(used));
  });
}

void CudaLanes::Return(std::unique_ptr<CudaLane> lane) {
  bool keeps_handle = !lane->has_gemm();
  if (!keeps_handle) {
    const MutexLock lock(&mutex_);
    keeps_handle = std::ranges::count_if(free_, &CudaLane::has_gemm) < kMostIdleHandles;
  }
  if (!keeps_handle) {
    const DeviceGuard guard(memory_->device());
    lane->DropGemm();
  }
  const MutexLock lock(&mutex_);
  free_.push_back(std::move(lane));
}

}  // namespace latticed
