// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_context.h"

#include "core/base/status_macros.h"
#include "core/view/allowed_threads.h"

namespace latticed {

CudaContext::CudaContext(int device, const CudaOptions& options,
                         std::shared_ptr<DeviceMemory> memory, CudaStream stream)
    : device_(device),
      memory_(std::move(memory)),
      pinned_(std::make_shared<PinnedMemory>(options.refuse_allocation)),
      lanes_(std::make_shared<CudaLanes>(memory_)),
      encoder_(options.encoder),
      arena_(AllowedThreads(options.threads)),
      stream_(std::move(stream)) {
  if (encoder_ == nullptr) encoder_ = MakeChunkEncoder("latticed");
}

absl::StatusOr<std::shared_ptr<CudaContext>> CudaContext::Create(int device,
                                                                 const CudaOptions& options) {
  LATTICED_RETURN_IF_ERROR(CheckDevice(device));
  const DeviceGuard guard(device);
  LATTICED_ASSIGN_OR_RETURN(
      auto memory, DeviceMemory::Create(device, options.memory_bytes, options.refuse_allocation,
                                        options.poison_memory));
  LATTICED_ASSIGN_OR_RETURN(auto stream, CudaStream::Create());
  return std::shared_ptr<CudaContext>(
      new CudaContext(device, options, std::move(memory), std::move(stream)));
}

absl::StatusOr<std::shared_ptr<const DeviceStage>> CudaContext::Stage(int degree, int segments,
                                                                      DeviceReservation& from) {
  if (auto known = StageNow(degree, segments); known != nullptr) return known;
  // Uploaded without the lock: others, of other sizes, do not wait for it.
  auto made = DeviceStage::Create(degree, segments, from, stream_);
  const MutexLock lock(&mutex_);
  std::weak_ptr<const DeviceStage>& kept = stages_[{degree, segments}];
  // Before a refusal is told: another's copy may be what has taken the room.
  if (auto known = kept.lock(); known != nullptr) {
    // Our copy is free before any later block is refused.
    if (made.ok()) from.LeaveBehind((*made)->MemoryBytes());
    return known;
  }
  if (!made.ok()) return made;
  kept = *made;
  return made;
}

uint64_t CudaContext::StageBytesToCome(int degree, int segments) {
  return StageNow(degree, segments) != nullptr ? 0 : DeviceStage::DeviceBytesFor(degree, segments);
}

std::shared_ptr<const DeviceStage> CudaContext::StageNow(int degree, int segments) {
  const MutexLock lock(&mutex_);
  return stages_[{degree, segments}].lock();
}

}  // namespace latticed
