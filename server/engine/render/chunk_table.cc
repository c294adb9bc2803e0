// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/chunk_table.h"

#include <algorithm>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace latticed {

size_t ChunkTable::Chunks::OwnerFor(const SharedBytes& of) {
  auto at = owners.end();
  if (of.block_bytes > 0) at = std::ranges::find(owners, of.owner, &Owner::owner);
  if (at == owners.end()) at = std::ranges::find(owners, 0u, &Owner::chunks);
  if (at == owners.end()) at = owners.insert(at, Owner());
  if (at->chunks == 0) *at = {of.owner, of.block_bytes};
  return static_cast<size_t>(at - owners.begin());
}

void ChunkTable::Chunks::SetData(size_t i, const SharedBytes& to) {
  // After this, nothing throws.
  if (owners.size() == owners.capacity()) owners.reserve(2 * owners.size() + 1);
  if (data[i] != nullptr) {
    Owner& before = owners[owner_of[i]];
    before.used -= sizes[i];
    if (--before.chunks == 0) before = {};
  }
  data[i] = to.data;
  sizes[i] = static_cast<uint32_t>(to.size);
  if (to.data == nullptr) return;
  const size_t at = OwnerFor(to);
  owner_of[i] = static_cast<uint8_t>(at);
  owners[at].used += to.size;
  ++owners[at].chunks;
}

ChunkTable::Chunks& ChunkTable::Group::Own() {
  if (shared) {
    chunks = std::make_shared<Chunks>(*chunks);
    shared = false;  // after what may throw
  }
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

SharedBytes ChunkTable::Data(size_t chunk) const {
  const Chunks& chunks = *groups_[chunk / kGroup].chunks;
  const std::span<const uint8_t> bytes = chunks.At(chunk % kGroup).data;
  if (bytes.data() == nullptr) return {};
  const Owner& owner = chunks.owners[chunks.owner_of[chunk % kGroup]];
  return {owner.owner, bytes.data(), bytes.size(), owner.block_bytes};
}

void ChunkTable::Set(size_t chunk, const NewChunk& to) {
  Chunks& chunks = groups_[chunk / kGroup].Own();
  const size_t i = chunk % kGroup;
  chunks.newest_revision = std::max(chunks.newest_revision, to.revision);
  chunks.revisions[i] = to.revision;
  chunks.digests[i] = to.digest;
  chunks.SetData(i, to.data);
}

void ChunkTable::CopyData(size_t chunk) {
  const std::span<const uint8_t> bytes = (*this)[chunk].data;
  const SharedBytes copy = MakeSharedBytes({bytes.begin(), bytes.end()});
  groups_[chunk / kGroup].Own().SetData(chunk % kGroup, copy);
}

void ChunkTable::SetDigest(size_t chunk, const VertexDigest& to) {
  if ((*this)[chunk].digest == to) return;
  groups_[chunk / kGroup].Own().digests[chunk % kGroup] = to;
}

uint64_t ChunkTable::MostBytes(size_t size) {
  const uint64_t groups = (size + kGroup - 1) / kGroup;
  return groups * (sizeof(Group) + sizeof(Chunks)) + size * 2 * sizeof(Owner);
}

std::vector<uint32_t> ChunkTable::ChangedAfter(uint64_t revision) const {
  std::vector<uint32_t> changed;
  for (size_t first = 0; first < size_; first += kGroup) {
    const Chunks& chunks = *groups_[first / kGroup].chunks;
    if (chunks.newest_revision <= revision) continue;
    for (size_t i = 0; i < std::min(kGroup, size_ - first); ++i) {
      if (chunks.revisions[i] > revision) changed.push_back(static_cast<uint32_t>(first + i));
    }
  }
  return changed;
}

std::vector<BlockUse> ChunkTable::Blocks() const {
  absl::flat_hash_map<const void*, BlockUse> sums;
  for (const Group& group : groups_) {
    for (const Owner& one : group.chunks->owners) {
      if (one.block_bytes == 0) continue;
      const void* const owner = one.owner.get();
      sums.try_emplace(owner, BlockUse{owner, one.block_bytes}).first->second.used += one.used;
    }
  }
  std::vector<BlockUse> blocks;
  for (const auto& [owner, sum] : sums) blocks.push_back(sum);
  return blocks;
}

uint64_t ChunkTable::BytesOfNoBlock() const {
  uint64_t bytes = 0;
  for (const Group& group : groups_) {
    for (const Owner& one : group.chunks->owners) bytes += one.block_bytes == 0 ? one.used : 0;
  }
  return bytes;
}

}  // namespace latticed
