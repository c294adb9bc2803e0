// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/bounds/encode_bounds.h"

#include <memory>
#include <utility>
#include <vector>

#include "core/view/view_encoder.h"

namespace latticed {

void EncodeBounds(std::span<const uint32_t> chunks,
                  absl::FunctionRef<std::span<const uint8_t>(uint32_t chunk)> bytes_of,
                  std::span<VertexDigest> digests, std::span<SharedBytes> results) {
  std::vector<size_t> changed;  // of chunks
  changed.reserve(chunks.size());
  size_t size = 0;
  for (size_t i = 0; i < chunks.size(); ++i) {
    const std::span<const uint8_t> bytes = bytes_of(chunks[i]);
    if (!digests.empty()) {
      const VertexDigest digest = DigestOf(bytes);
      if (std::exchange(digests[i], digest) == digest) continue;
    }
    changed.push_back(i);
    size += bytes.size();
  }
  const auto block = std::make_shared<std::vector<uint8_t>>();
  block->reserve(size);
  for (const size_t i : changed) {
    const std::span<const uint8_t> bytes = bytes_of(chunks[i]);
    results[i] = {block, block->data() + block->size(), bytes.size(), size};
    block->insert(block->end(), bytes.begin(), bytes.end());
  }
}

}  // namespace latticed
