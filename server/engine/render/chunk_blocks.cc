// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_blocks.h"

#include <span>

#include "absl/container/flat_hash_set.h"

namespace latticed {
namespace {

constexpr uint64_t kMostBlocks = 4;  // bytes of blocks for each byte of chunks in them

BlockUse SumOf(const std::vector<BlockUse>& blocks) {
  BlockUse sum;
  for (const BlockUse& block : blocks) {
    sum.bytes += block.bytes;
    sum.used += block.used;
  }
  return sum;
}

}  // namespace

uint64_t HeldBytes(const ChunkTable& chunks) {
  return SumOf(chunks.Blocks()).bytes + chunks.BytesOfNoBlock();
}

void LeaveEmptyBlocks(Snapshot& snapshot) {
  ChunkTable& chunks = snapshot.chunks;
  absl::flat_hash_set<const void*> mostly_empty;
  for (const BlockUse& block : chunks.Blocks()) {
    if (2 * block.used < block.bytes) mostly_empty.insert(block.owner);
  }
  for (size_t c = 0; c < chunks.size(); ++c) {
    if (!mostly_empty.contains(chunks.Data(c).owner.get())) continue;
    chunks.CopyData(c);
  }
  snapshot.held_bytes = HeldBytes(chunks);
}

void KeepBlocksFew(Snapshot& snapshot) {
  const BlockUse sum = SumOf(snapshot.chunks.Blocks());
  snapshot.held_bytes = sum.bytes + snapshot.chunks.BytesOfNoBlock();
  if (sum.bytes > kMostBlocks * sum.used) LeaveEmptyBlocks(snapshot);
}

}  // namespace latticed
