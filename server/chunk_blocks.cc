// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/chunk_blocks.h"

#include <span>

#include "absl/container/flat_hash_map.h"

namespace latticed {
namespace {

constexpr uint64_t kMostBlocks = 4;  // times the chunks

struct Block {
  uint64_t bytes = 0, used = 0;
};
using Blocks = absl::flat_hash_map<const void*, Block>;

bool IsPart(const SnapshotChunk& chunk) { return chunk.data.block_bytes > 0; }

Blocks BlocksOf(const std::vector<SnapshotChunk>& chunks) {
  Blocks blocks;
  for (const SnapshotChunk& chunk : chunks) {
    if (!IsPart(chunk)) continue;
    Block& block = blocks[chunk.data.owner.get()];
    block.bytes = chunk.data.block_bytes;
    block.used += chunk.data.size;
  }
  return blocks;
}

}  // namespace

uint64_t BlockBytes(const std::vector<SnapshotChunk>& chunks) {
  uint64_t bytes = 0;
  for (const auto& [owner, block] : BlocksOf(chunks)) bytes += block.bytes;
  return bytes;
}

void LeaveEmptyBlocks(std::vector<SnapshotChunk>& chunks) {
  const Blocks blocks = BlocksOf(chunks);
  for (SnapshotChunk& chunk : chunks) {
    if (!IsPart(chunk)) continue;
    const Block& block = blocks.at(chunk.data.owner.get());
    if (2 * block.used >= block.bytes) continue;
    const std::span<const uint8_t> bytes = chunk.data.span();
    chunk.data = MakeSharedBytes({bytes.begin(), bytes.end()});
  }
}

void KeepBlocksFew(uint64_t made, Snapshot& snapshot) {
  snapshot.block_bytes += made;
  uint64_t used = 0;
  for (const SnapshotChunk& chunk : snapshot.chunks) used += chunk.data.size;
  if (snapshot.block_bytes <= kMostBlocks * used) return;
  LeaveEmptyBlocks(snapshot.chunks);
  snapshot.block_bytes = BlockBytes(snapshot.chunks);
}

}  // namespace latticed
