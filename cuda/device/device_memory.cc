// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_memory.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

struct OnDevice {
  size_t free = 0, total = 0;
};
absl::StatusOr<OnDevice> LookAtDevice() {
  OnDevice bytes;
  if (auto s = CudaStatus(cudaMemGetInfo(&bytes.free, &bytes.total), "the device's memory");
      !s.ok()) {
    return s;
  }
  return bytes;
}

}  // namespace

absl::StatusOr<std::shared_ptr<DeviceMemory>> DeviceMemory::Create(int device,
                                                                   uint64_t budget_bytes,
                                                                   RefuseAllocation refuse,
                                                                   bool poison) {
  const DeviceGuard guard(device);
  const auto bytes = LookAtDevice();
  if (!bytes.ok()) return bytes.status();
  if (budget_bytes == 0) budget_bytes = bytes->free / 10 * 9;
  cudaMemPoolProps properties{};
  properties.allocType = cudaMemAllocationTypePinned;
  properties.location = {cudaMemLocationTypeDevice, device};
  cudaMemPool_t pool = nullptr;
  if (auto s = CudaStatus(cudaMemPoolCreate(&pool, &properties), "the device's memory"); !s.ok()) {
    return s;
  }
  // Not given back at every synchronisation: edits allocate nothing, new views reuse.
  uint64_t keep = std::numeric_limits<uint64_t>::max();
  if (auto s = CudaStatus(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep),
                          "the device's memory");
      !s.ok()) {
    static_cast<void>(cudaMemPoolDestroy(pool));
    return s;
  }
  return std::shared_ptr<DeviceMemory>(
      new DeviceMemory(device, bytes->total, budget_bytes, std::move(refuse), poison, pool));
}

DeviceMemory::DeviceMemory(int device, uint64_t device_bytes, uint64_t budget_bytes,
                           RefuseAllocation refuse, bool poison, cudaMemPool_t pool)
    : device_(device),
      device_bytes_(device_bytes),
      budget_bytes_(budget_bytes),
      refuse_(std::move(refuse)),
      poison_(poison),
      pool_(pool) {}

DeviceMemory::~DeviceMemory() { static_cast<void>(cudaMemPoolDestroy(pool_)); }

absl::StatusOr<void*> DeviceMemory::Allocate(std::string_view purpose, size_t bytes,
                                             cudaStream_t stream) {
  if (bytes == 0) return nullptr;
  const std::scoped_lock lock(mutex_);
  const uint64_t free = budget_bytes_ - used_bytes_;
  if (bytes > free || (refuse_ && refuse_(purpose, bytes))) {
    return error::OutOfDeviceMemory(purpose, device_, bytes, free);
  }
  const DeviceGuard guard(device_);
  void* data = nullptr;
  const cudaError_t result = cudaMallocFromPoolAsync(&data, bytes, pool_, stream);
  if (result == cudaErrorMemoryAllocation) {
    // Others use the device too.
    static_cast<void>(cudaGetLastError());
    return error::OutOfDeviceMemory(
        purpose, device_, bytes,
        std::min<uint64_t>(free, LookAtDevice().value_or(OnDevice{}).free));
  }
  if (auto s = CudaStatus(result, purpose); !s.ok()) return s;
  if (poison_) static_cast<void>(cudaMemsetAsync(data, 0xff, bytes, stream));
  used_bytes_ += bytes;
  use_[std::string(purpose)] += bytes;
  return data;
}

void DeviceMemory::Free(void* data, std::string_view purpose, size_t bytes, cudaStream_t stream) {
  if (data == nullptr) return;
  const DeviceGuard guard(device_);
  static_cast<void>(cudaFreeAsync(data, stream));
  const std::scoped_lock lock(mutex_);
  used_bytes_ -= bytes;
  use_[std::string(purpose)] -= bytes;
}

uint64_t DeviceMemory::free_bytes() const {
  const std::scoped_lock lock(mutex_);
  return budget_bytes_ - used_bytes_;
}

MemoryUse DeviceMemory::use() const {
  const std::scoped_lock lock(mutex_);
  return use_;
}

}  // namespace latticed
