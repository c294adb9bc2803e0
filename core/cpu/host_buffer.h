// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Owner of a block of host memory, aligned to a cache line. It returns an error instead of
// throwing.
//
// Errors   kResourceExhausted with asked and free bytes
#ifndef LATTICED_CORE_CPU_HOST_BUFFER_H_
#define LATTICED_CORE_CPU_HOST_BUFFER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string_view>

#include "absl/status/statusor.h"

namespace latticed {

class HostBuffer {
 public:
  HostBuffer() = default;

  // Zeroed bytes for `purpose`, as in MemoryUse. More than the machine's memory is refused at once;
  // the kernel would grant it and kill the process later.
  [[nodiscard]] static absl::StatusOr<HostBuffer> Create(std::string_view purpose, size_t bytes);

  size_t size() const { return size_; }
  std::span<uint8_t> span() { return {data_.get(), size_}; }
  std::span<const uint8_t> span() const { return {data_.get(), size_}; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(uint8_t* data) const { ::operator delete(data, kAlignment); }
  };

  std::unique_ptr<uint8_t, Free> data_;
  size_t size_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_HOST_BUFFER_H_
