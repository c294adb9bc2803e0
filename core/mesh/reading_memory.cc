// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/reading_memory.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"

namespace latticed {

absl::Status ReadingMemory::Hold(uint64_t bytes) {
  if (bytes <= held_bytes_) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(grant_(bytes));
  held_bytes_ = bytes;
  return absl::OkStatus();
}

absl::Status MeshGrowth::Reserve(uint64_t bytes, uint64_t beside) {
  if (memory_ == nullptr) return absl::OkStatus();
  return memory_->Hold(MostBytes(appended_bytes_) + bytes + beside);
}

uint64_t MeshGrowth::MostBytes(uint64_t coming) const {
  uint64_t bytes = name_bytes_ + 3 * coming, largest = 0;
  const auto add = [&](const auto& values, uint64_t least_bytes = 0) {
    constexpr size_t kSize = sizeof(values[0]);
    const uint64_t used = std::max(values.size() * kSize, least_bytes);
    const uint64_t kept = values.capacity() * kSize;
    if (kept >= used + coming) {  // does not grow
      bytes += kept;
    } else {
      bytes += std::max(2 * used, kept);
      largest = std::max(largest, used);
    }
  };
  // An index per corner is added for all corners once one of them has a normal or UV.
  const uint64_t index_bytes = mesh_->corner_count() * sizeof(uint32_t);
  add(mesh_->positions);
  add(mesh_->face_offsets);
  add(mesh_->corner_vertices);
  add(mesh_->normals);
  add(mesh_->corner_normals, index_bytes);
  add(mesh_->uvs);
  add(mesh_->corner_uvs, index_bytes);
  add(mesh_->face_groups);
  add(mesh_->group_names);
  return bytes + largest;
}

// Until the next question, another kStepBytes may be appended.
absl::Status MeshGrowth::Ask(uint64_t beside) {
  const uint64_t appended = std::exchange(appended_bytes_, 0);
  if (memory_ == nullptr) return absl::OkStatus();
  return memory_->Hold(MostBytes(appended + kStepBytes) + beside);
}

}  // namespace latticed
