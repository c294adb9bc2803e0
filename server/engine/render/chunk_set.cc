// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_set.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace latticed {

void ChunkSet::Add(std::span<const uint32_t> chunks) {
  if (all_) return;
  std::vector<uint32_t> both;
  both.reserve(some_.size() + chunks.size());
  std::ranges::set_union(some_, chunks, std::back_inserter(both));
  some_ = std::move(both);
}

size_t ChunkSet::Count(size_t count) const {
  if (all_) return count;
  return static_cast<size_t>(std::ranges::lower_bound(some_, count) - some_.begin());
}

std::vector<uint32_t> ChunkSet::Take(size_t count) {
  std::vector<uint32_t> chunks = std::exchange(some_, {});
  if (std::exchange(all_, false)) {
    chunks.resize(count);
    std::iota(chunks.begin(), chunks.end(), 0u);
  } else {
    chunks.erase(std::ranges::lower_bound(chunks, count), chunks.end());
  }
  return chunks;
}

}  // namespace latticed
