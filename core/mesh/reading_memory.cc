// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/reading_memory.h"

#include <utility>

#include "core/base/status_macros.h"

namespace latticed {

absl::Status ReadingMemory::Hold(uint64_t bytes) {
  if (grant_ == nullptr || bytes <= held_bytes_) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(grant_(bytes));
  held_bytes_ = bytes;
  return absl::OkStatus();
}

absl::Status MeshGrowth::Reserve(uint64_t bytes, uint64_t beside) {
  if (memory_ == nullptr) return absl::OkStatus();
  return memory_->Hold(mesh_->MemoryBytes() + bytes + 3 * (appended_bytes_ + beside));
}

// Until the next question, another kStepBytes may be appended.
absl::Status MeshGrowth::Ask(uint64_t beside) {
  const uint64_t appended = std::exchange(appended_bytes_, 0);
  if (memory_ == nullptr) return absl::OkStatus();
  return memory_->Hold(3 * (mesh_->MemoryBytes() + appended + kStepBytes + beside));
}

}  // namespace latticed
