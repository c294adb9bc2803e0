// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_context.h"

#include "core/base/status_macros.h"
#include "core/view/machine.h"

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
  const MutexLock lock(&mutex_);
  std::weak_ptr<const DeviceStage>& kept = stages_[{degree, segments}];
  if (auto known = kept.lock(); known != nullptr) return known;
  LATTICED_ASSIGN_OR_RETURN(auto made, DeviceStage::Create(degree, segments, from, stream_));
  kept = made;
  return made;
}

uint64_t CudaContext::StageBytesToCome(int degree, int segments) {
  const MutexLock lock(&mutex_);
  return stages_[{degree, segments}].expired() ? DeviceStage::DeviceBytesFor(degree, segments) : 0;
}

}  // namespace latticed
