// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_memory.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

struct OnDevice {
  size_t free = 0, total = 0;
};
absl::StatusOr<OnDevice> LookAtDevice() {
  OnDevice bytes;
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemGetInfo(&bytes.free, &bytes.total), "the device's memory"));
  return bytes;
}

}  // namespace

absl::StatusOr<std::shared_ptr<DeviceMemory>> DeviceMemory::Create(int device,
                                                                   uint64_t budget_bytes,
                                                                   RefuseAllocation refuse,
                                                                   bool poison) {
  const DeviceGuard guard(device);
  LATTICED_ASSIGN_OR_RETURN(const auto bytes, LookAtDevice());
  if (budget_bytes == 0) budget_bytes = bytes.free / 10 * 9;
  cudaMemPoolProps properties{};
  properties.allocType = cudaMemAllocationTypePinned;
  properties.location = {cudaMemLocationTypeDevice, device};
  cudaMemPool_t pool = nullptr;
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemPoolCreate(&pool, &properties), "the device's memory"));
  // The pool keeps freed blocks for new views instead of returning them to the driver at each
  // synchronisation.
  uint64_t keep = std::numeric_limits<uint64_t>::max();
  if (auto s = CudaStatus(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep),
                          "the device's memory");
      !s.ok()) {
    static_cast<void>(cudaMemPoolDestroy(pool));
    return s;
  }
  return std::shared_ptr<DeviceMemory>(
      new DeviceMemory(device, bytes.total, budget_bytes, std::move(refuse), poison, pool));
}

DeviceMemory::DeviceMemory(int device, uint64_t device_bytes, uint64_t budget_bytes,
                           RefuseAllocation refuse, bool poison, cudaMemPool_t pool)
    : device_(device),
      device_bytes_(device_bytes),
      budget_(device, budget_bytes),
      refuse_(std::move(refuse)),
      poison_(poison),
      pool_(pool) {}

DeviceMemory::~DeviceMemory() { static_cast<void>(cudaMemPoolDestroy(pool_)); }

absl::StatusOr<void*> DeviceMemory::Allocate(std::string_view purpose, size_t bytes,
                                             cudaStream_t stream) {
  LATTICED_RETURN_IF_ERROR(budget_.Reserve(purpose, bytes));
  auto data = AllocateReserved(purpose, bytes, bytes, stream);
  if (!data.ok()) budget_.GiveBack(bytes);
  return data;
}

absl::StatusOr<void*> DeviceMemory::AllocateReserved(std::string_view purpose, size_t bytes,
                                                     uint64_t reserved_bytes, cudaStream_t stream) {
  if (bytes == 0) return nullptr;
  const auto out_of_memory = [&](uint64_t free_on_device) {
    return error::OutOfDeviceMemory(
        purpose, device_, bytes, std::min(budget_.free_bytes() + reserved_bytes, free_on_device));
  };
  if (refuse_ && refuse_(purpose, bytes)) return out_of_memory(device_bytes_);
  const DeviceGuard guard(device_);
  void* data = nullptr;
  const cudaError_t result = cudaMallocFromPoolAsync(&data, bytes, pool_, stream);
  if (result == cudaErrorMemoryAllocation) {
    // Other processes use the device too, so its free bytes may be less than the budget says.
    static_cast<void>(cudaGetLastError());
    return out_of_memory(LookAtDevice().value_or(OnDevice{}).free);
  }
  LATTICED_RETURN_IF_ERROR(CudaStatus(result, purpose));
  if (poison_) static_cast<void>(cudaMemsetAsync(data, 0xff, bytes, stream));
  budget_.Use(purpose, bytes);
  return data;
}

void DeviceMemory::Free(void* data, std::string_view purpose, size_t bytes, cudaStream_t stream) {
  if (data == nullptr) return;
  const DeviceGuard guard(device_);
  static_cast<void>(cudaFreeAsync(data, stream));
  budget_.Return(purpose, bytes);
}

}  // namespace latticed
