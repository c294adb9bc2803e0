// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device_budget.h"

#include <string>

#include "core/base/error.h"

namespace latticed {

absl::Status DeviceBudget::Reserve(std::string_view what, uint64_t bytes) {
  const MutexLock lock(&mutex_);
  const uint64_t free = bytes_ - taken_bytes_;
  if (bytes > free) return error::OutOfDeviceMemory(what, device_, bytes, free);
  taken_bytes_ += bytes;
  return absl::OkStatus();
}

void DeviceBudget::GiveBack(uint64_t bytes) {
  const MutexLock lock(&mutex_);
  taken_bytes_ -= bytes;
}

void DeviceBudget::Use(std::string_view purpose, uint64_t bytes) {
  const MutexLock lock(&mutex_);
  use_[std::string(purpose)] += bytes;
}

void DeviceBudget::Return(std::string_view purpose, uint64_t bytes) {
  const MutexLock lock(&mutex_);
  use_[std::string(purpose)] -= bytes;
  taken_bytes_ -= bytes;
}

uint64_t DeviceBudget::free_bytes() const {
  const MutexLock lock(&mutex_);
  return bytes_ - taken_bytes_;
}

MemoryUse DeviceBudget::use() const {
  const MutexLock lock(&mutex_);
  return use_;
}

}  // namespace latticed
