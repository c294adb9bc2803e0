// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_set.h"

#include <algorithm>

namespace latticed {

void ChunkSet::Add(std::span<const uint32_t> chunks) {
  if (all_) return;
  for (const uint32_t chunk : chunks) {
    if (chunk >= some_.size()) some_.resize(chunk + size_t{1});
    some_[chunk] = true;
  }
}

size_t ChunkSet::Count(size_t count) const {
  if (all_) return count;
  const auto end = some_.begin() + static_cast<std::ptrdiff_t>(std::min(count, some_.size()));
  return static_cast<size_t>(std::count(some_.begin(), end, true));
}

std::vector<uint32_t> ChunkSet::Take(size_t count) {
  std::vector<uint32_t> chunks;
  const size_t end = all_ ? count : std::min(count, some_.size());
  for (size_t c = 0; c < end; ++c) {
    if (all_ || some_[c]) chunks.push_back(static_cast<uint32_t>(c));
  }
  all_ = false;
  some_.assign(some_.size(), false);
  return chunks;
}

}  // namespace latticed
