// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks of a snapshot, in groups that snapshots share. After an edit that reaches few chunks of
// thousands, the next snapshot copies only their groups, and a pointer for each of the others.
//
// Threads  any thread may read a table that nobody writes. A table that Share returned may be written
//          while the original is read
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_TABLE_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/backend.h"

namespace latticed {

// PatternKey::Code of each patch of a chunk.
using ChunkPatterns = std::vector<uint16_t>;

struct SnapshotChunk {
  uint64_t revision = 0;  // at which its bytes or its patterns last changed
  SharedBytes data;
  VertexDigest digest;  // of the vertices that `data` encodes
  // Null without a tolerance.
  std::shared_ptr<const ChunkPatterns> patterns = nullptr;

  // Of data and patterns.
  size_t bytes() const {
    return data.size + (patterns != nullptr ? patterns->size() * sizeof(uint16_t) : 0);
  }
};

// A block that chunks are parts of: SharedBytes::block_bytes.
struct BlockUse {
  const void* owner = nullptr;
  uint64_t bytes = 0;
  uint64_t used = 0;  // bytes that are of chunks in the table
};

class ChunkTable {
 public:
  explicit ChunkTable(size_t size = 0);
  ChunkTable(ChunkTable&&) = default;
  ChunkTable& operator=(ChunkTable&&) = default;

  // Returns a table of the same chunks. Set must not be called on this one afterwards.
  [[nodiscard]] ChunkTable Share() const;

  size_t size() const { return size_; }
  const SnapshotChunk& operator[](size_t chunk) const {
    return groups_[chunk / kGroup].chunks->at[chunk % kGroup];
  }
  void Set(size_t chunk, SnapshotChunk to);
  // Keeps the bytes and the revision. A chunk that has the digest already stays shared.
  void SetDigest(size_t chunk, const VertexDigest& to);
  // The chunks with a later revision, ascending.
  [[nodiscard]] std::vector<uint32_t> ChangedAfter(uint64_t revision) const;
  // Every block once, and the bytes of chunks that are part of no block. Both take time by the number of
  // groups, not of chunks.
  [[nodiscard]] std::vector<BlockUse> Blocks() const;
  [[nodiscard]] uint64_t BytesOfNoBlock() const;

 private:
  static constexpr size_t kGroup = 64;
  struct Chunks {
    std::array<SnapshotChunk, kGroup> at;
    uint64_t newest_revision = 0;  // or later
    std::vector<BlockUse> blocks;  // of the chunks of this group
    uint64_t bytes_of_no_block = 0;

    void Add(const SharedBytes& data);
    void Remove(const SharedBytes& data);
  };
  struct Group {
    std::shared_ptr<Chunks> chunks;
    bool shared = false;  // with a table that others read

    Chunks& Own();
  };

  size_t size_;
  std::vector<Group> groups_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_TABLE_H_
