// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_table.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace latticed {
namespace {

auto Of(std::vector<BlockUse>& blocks, const SharedBytes& data) {
  return std::ranges::find(blocks, data.owner.get(), &BlockUse::owner);
}

}  // namespace

void ChunkTable::Chunks::Add(const SharedBytes& data) {
  if (data.block_bytes == 0) {
    bytes_of_no_block += data.size;
  } else if (const auto block = Of(blocks, data); block != blocks.end()) {
    block->used += data.size;
  } else {
    blocks.push_back({data.owner.get(), data.block_bytes, data.size});
  }
}

void ChunkTable::Chunks::Remove(const SharedBytes& data) {
  if (data.block_bytes == 0) {
    bytes_of_no_block -= data.size;
    return;
  }
  const auto block = Of(blocks, data);
  block->used -= data.size;
  if (block->used == 0) blocks.erase(block);
}

ChunkTable::Chunks& ChunkTable::Group::Own() {
  if (std::exchange(shared, false)) chunks = std::make_shared<Chunks>(*chunks);
  return *chunks;
}

ChunkTable::ChunkTable(size_t size) : size_(size), groups_((size + kGroup - 1) / kGroup) {
  for (Group& group : groups_) group.chunks = std::make_shared<Chunks>();
}

ChunkTable ChunkTable::Share() const {
  ChunkTable table;
  table.size_ = size_;
  table.groups_.reserve(groups_.size());
  for (const Group& group : groups_) table.groups_.push_back({group.chunks, true});
  return table;
}

void ChunkTable::Set(size_t chunk, SnapshotChunk to) {
  Chunks& chunks = groups_[chunk / kGroup].Own();
  chunks.newest_revision = std::max(chunks.newest_revision, to.revision);
  chunks.Remove(chunks.at[chunk % kGroup].data);
  chunks.Add(to.data);
  chunks.at[chunk % kGroup] = std::move(to);
}

void ChunkTable::SetDigest(size_t chunk, const VertexDigest& to) {
  if ((*this)[chunk].digest == to) return;
  groups_[chunk / kGroup].Own().at[chunk % kGroup].digest = to;
}

std::vector<uint32_t> ChunkTable::ChangedAfter(uint64_t revision) const {
  std::vector<uint32_t> changed;
  for (size_t first = 0; first < size_; first += kGroup) {
    const Chunks& chunks = *groups_[first / kGroup].chunks;
    if (chunks.newest_revision <= revision) continue;
    for (size_t i = 0; i < std::min(kGroup, size_ - first); ++i) {
      if (chunks.at[i].revision > revision) changed.push_back(static_cast<uint32_t>(first + i));
    }
  }
  return changed;
}

std::vector<BlockUse> ChunkTable::Blocks() const {
  absl::flat_hash_map<const void*, BlockUse> sums;
  for (const Group& group : groups_) {
    for (const BlockUse& block : group.chunks->blocks) {
      BlockUse& sum =
          sums.try_emplace(block.owner, BlockUse{block.owner, block.bytes}).first->second;
      sum.used += block.used;
    }
  }
  std::vector<BlockUse> blocks;
  for (const auto& [owner, sum] : sums) blocks.push_back(sum);
  return blocks;
}

uint64_t ChunkTable::BytesOfNoBlock() const {
  uint64_t bytes = 0;
  for (const Group& group : groups_) bytes += group.chunks->bytes_of_no_block;
  return bytes;
}

}  // namespace latticed
