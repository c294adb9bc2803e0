// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by all targets and views on one device: memory, streams, stage matrices, the encoder and
// its threads. Twin of core/cpu/cpu_context.h.
//
// Errors   those of cuda_status.h and device_memory.h
// Threads  safe
#ifndef LATTICED_CUDA_DEVICE_CUDA_CONTEXT_H_
#define LATTICED_CUDA_DEVICE_CUDA_CONTEXT_H_

#include <map>
#include <memory>
#include <utility>

#include "core/base/mutex.h"
#include "core/view/cpu_arena.h"
#include "cuda/device/cuda_lanes.h"
#include "cuda/device/cuda_options.h"
#include "cuda/device/device_memory.h"
#include "cuda/device/device_stage.h"
#include "cuda/device/pinned_memory.h"

namespace latticed {

class CudaContext {
 public:
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<CudaContext>> Create(
      int device, const CudaOptions& options);

  int device() const { return device_; }
  const std::shared_ptr<DeviceMemory>& memory() const { return memory_; }
  PinnedMemory& pinned() const { return *pinned_; }
  CudaLanes& lanes() const { return *lanes_; }
  // The stream on which data that outlives a view is uploaded and freed.
  const CudaStream& stream() const { return stream_; }
  const std::shared_ptr<const ChunkEncoder>& encoder() const { return encoder_; }
  CpuArena& arena() { return arena_; }

  // Stage matrices. They are uploaded once and shared while anyone holds them. An upload takes
  // StageBytesToCome from the reservation.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const DeviceStage>> Stage(int degree, int segments,
                                                                         DeviceReservation& from);
  // The bytes that Stage will allocate; 0 while the matrices exist.
  uint64_t StageBytesToCome(int degree, int segments);

 private:
  CudaContext(int device, const CudaOptions& options, std::shared_ptr<DeviceMemory> memory,
              CudaStream stream);

  int device_;
  std::shared_ptr<DeviceMemory> memory_;
  std::shared_ptr<PinnedMemory> pinned_;
  std::shared_ptr<CudaLanes> lanes_;
  std::shared_ptr<const ChunkEncoder> encoder_;
  CpuArena arena_;
  CudaStream stream_;
  Mutex mutex_;
  std::map<std::pair<int, int>, std::weak_ptr<const DeviceStage>> stages_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_CONTEXT_H_
