// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The memory of one device: a stream-ordered pool with a budget, its bytes counted by purpose.
//
// A block is usable on `stream` from Allocate on, and elsewhere once that stream has reached it.
// Free returns it when the stream gets there. Neither waits. Blocks stay with the pool.
//
// Blocks that are needed together are reserved together: device_reservation.h.
//
// Errors   kResourceExhausted with asked and free bytes, before anything is allocated where the
//          budget would not hold it; the CUDA error state is clean afterwards
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
  // budget_bytes 0: nine tenths of what the device has free.
  // `poison`: for tests, new blocks are all ones.
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
  // As in DeviceBudget. AllocateReserved allocates a block of reserved bytes. Where it fails they
  // stay reserved; the error counts them as free, with all `reserved_bytes` of the caller.
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
  uint64_t device_bytes() const { return device_bytes_; }  // of the device in all
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
