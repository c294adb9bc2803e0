// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/host_buffer.h"

#include <unistd.h>

#include <cstring>

#include "core/base/error.h"

namespace latticed {

size_t MachineBytes(int pages_name) {
  const long pages = sysconf(pages_name), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? static_cast<size_t>(pages) * static_cast<size_t>(size) : 0;
}

absl::Status HostMemoryExhausted(std::string_view purpose, size_t bytes) {
  return error::OutOfMemory(purpose, bytes, MachineBytes(_SC_AVPHYS_PAGES));
}

absl::StatusOr<HostBuffer> HostBuffer::Create(std::string_view purpose, size_t bytes) {
  if (bytes > MachineBytes(_SC_PHYS_PAGES)) return HostMemoryExhausted(purpose, bytes);
  HostBuffer buffer;
  buffer.data_.reset(static_cast<uint8_t*>(::operator new(bytes, kAlignment, std::nothrow)));
  if (buffer.data_ == nullptr) return HostMemoryExhausted(purpose, bytes);
  buffer.size_ = bytes;
  std::memset(buffer.data_.get(), 0, bytes);
  return buffer;
}

}  // namespace latticed
