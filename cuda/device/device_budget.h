// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The budget of a device's memory, and its use by purpose. A caller that needs several blocks first
// reserves the bytes of all of them. Where they do not all fit, it allocates none.
//
//   free --Reserve--> reserved --Use--> used     GiveBack and Return go the other way
//
// Errors   kResourceExhausted with asked and free bytes
// Threads  safe
#ifndef LATTICED_CUDA_DEVICE_DEVICE_BUDGET_H_
#define LATTICED_CUDA_DEVICE_DEVICE_BUDGET_H_

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/base/mutex.h"

namespace latticed {

class DeviceBudget {
 public:
  // `device`: the number that errors name.
  DeviceBudget(int device, uint64_t bytes) : device_(device), bytes_(bytes) {}

  // Reserves all of `bytes` or nothing. `what` names their user in the error.
  [[nodiscard]] absl::Status Reserve(std::string_view what, uint64_t bytes);
  // Frees bytes that were reserved but not used.
  void GiveBack(uint64_t bytes);
  // Turns reserved bytes into used ones. `purpose`: as in MemoryUse.
  void Use(std::string_view purpose, uint64_t bytes);
  // Frees bytes that were used.
  void Return(std::string_view purpose, uint64_t bytes);

  uint64_t bytes() const { return bytes_; }
  uint64_t free_bytes() const;  // neither reserved nor used
  MemoryUse use() const;        // of what is used

 private:
  const int device_;
  const uint64_t bytes_;
  mutable Mutex mutex_;
  uint64_t taken_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // reserved or used
  MemoryUse use_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_BUDGET_H_
