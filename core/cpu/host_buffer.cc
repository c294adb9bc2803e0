// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/host_buffer.h"

#include <unistd.h>

#include <cstring>

#include "core/base/error.h"
#include "core/view/machine.h"

namespace latticed {

absl::StatusOr<HostBuffer> HostBuffer::Create(std::string_view purpose, size_t bytes) {
  HostBuffer buffer;
  if (bytes <= MachineBytes(_SC_PHYS_PAGES)) {
    buffer.data_.reset(static_cast<uint8_t*>(::operator new(bytes, kAlignment, std::nothrow)));
  }
  if (buffer.data_ == nullptr) {
    return error::OutOfMemory(purpose, bytes, MachineBytes(_SC_AVPHYS_PAGES));
  }
  buffer.size_ = bytes;
  std::memset(buffer.data_.get(), 0, bytes);
  return buffer;
}

}  // namespace latticed
