// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory of one device: a stream-ordered pool with a budget. Bytes are counted by purpose.
//
// A block is usable on `stream` as soon as Allocate returns, and on other streams once that stream
// has passed the allocation. Free takes effect when its stream has passed it. Neither waits. The
// pool keeps freed blocks.
//
// Blocks that are needed together are reserved together: device_reservation.h.
//
// Errors   kResourceExhausted with asked and free bytes; where they exceed the budget, nothing is
//          allocated; the CUDA error state is clean afterwards
// Threads  safe
#ifndef LATTICED_CUDA_DEVICE_DEVICE_MEMORY_H_
#define LATTICED_CUDA_DEVICE_DEVICE_MEMORY_H_

#include <cuda_runtime_api.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "cuda/device/device_budget.h"

namespace latticed {

// For tests: returns true to refuse an allocation.
using RefuseAllocation = std::function<bool(std::string_view purpose, uint64_t bytes)>;

class DeviceMemory {
 public:
  // `budget_bytes`: 0 means nine tenths of the device's free memory. `poison`: for tests, sets all
  // bits of new blocks.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<DeviceMemory>> Create(int device,
                                                                            uint64_t budget_bytes,
                                                                            RefuseAllocation refuse,
                                                                            bool poison = false);
  ~DeviceMemory();
  DeviceMemory(const DeviceMemory&) = delete;  // owns the pool
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  // `purpose` as in MemoryUse.
  [[nodiscard]] absl::StatusOr<void*> Allocate(std::string_view purpose, size_t bytes,
                                               cudaStream_t stream);
  // Reserve and GiveBack: as in DeviceBudget. AllocateReserved allocates a block from reserved bytes.
  // If it fails, they stay reserved, and the error counts all `reserved_bytes` of the caller as free.
  [[nodiscard]] absl::Status Reserve(std::string_view what, uint64_t bytes) {
    return budget_.Reserve(what, bytes);
  }
  void GiveBack(uint64_t bytes) { budget_.GiveBack(bytes); }
  [[nodiscard]] absl::StatusOr<void*> AllocateReserved(std::string_view purpose, size_t bytes,
                                                       uint64_t reserved_bytes,
                                                       cudaStream_t stream);
  // Frees a block of Allocate or AllocateReserved, with its purpose and size. Null is allowed.
  void Free(void* data, std::string_view purpose, size_t bytes, cudaStream_t stream);

  int device() const { return device_; }
  uint64_t device_bytes() const { return device_bytes_; }  // in all, budget or not
  uint64_t budget_bytes() const { return budget_.bytes(); }
  uint64_t free_bytes() const { return budget_.free_bytes(); }
  MemoryUse use() const { return budget_.use(); }

 private:
  DeviceMemory(int device, uint64_t device_bytes, uint64_t budget_bytes, RefuseAllocation refuse,
               bool poison, cudaMemPool_t pool);

  int device_;
  uint64_t device_bytes_;
  DeviceBudget budget_;
  RefuseAllocation refuse_;
  bool poison_;
  cudaMemPool_t pool_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_MEMORY_H_
