// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/chunk_blocks.h"

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
  const void* last = nullptr;  // neighbours are mostly of one
  Block* block = nullptr;
  for (const SnapshotChunk& chunk : chunks) {
    if (!IsPart(chunk)) continue;
    if (const void* owner = chunk.data.owner.get(); owner != last) {
      last = owner;
      block = &blocks[owner];
      block->bytes = chunk.data.block_bytes;
    }
    block->used += chunk.data.size;
  }
  return blocks;
}

Block SumOf(const Blocks& blocks) {
  Block sum;
  for (const auto& [owner, block] : blocks) {
    sum.bytes += block.bytes;
    sum.used += block.used;
  }
  return sum;
}

uint64_t BytesOfNoBlock(const std::vector<SnapshotChunk>& chunks) {
  uint64_t bytes = 0;
  for (const SnapshotChunk& chunk : chunks) bytes += IsPart(chunk) ? 0 : chunk.data.size;
  return bytes;
}

}  // namespace

uint64_t HeldBytes(const std::vector<SnapshotChunk>& chunks) {
  return SumOf(BlocksOf(chunks)).bytes + BytesOfNoBlock(chunks);
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

void KeepBlocksFew(Snapshot& snapshot) {
  const Block sum = SumOf(BlocksOf(snapshot.chunks));
  snapshot.held_bytes = sum.bytes + BytesOfNoBlock(snapshot.chunks);
  if (sum.bytes <= kMostBlocks * sum.used) return;
  LeaveEmptyBlocks(snapshot.chunks);
  snapshot.held_bytes = HeldBytes(snapshot.chunks);
}

}  // namespace latticed
