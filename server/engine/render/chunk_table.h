// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks of a snapshot, in groups that snapshots share. After an edit that reaches few chunks of
// thousands, the next snapshot copies only their groups, and a pointer for each of the others.
//
// A group keeps each block of encoded bytes once, not once a chunk: to count the owners of thousands of chunks would
// take as long as a tenth of their encoding.
//
// Threads  any thread may read a table that nobody writes. A table that Share returned may be written
//          while the original is read
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_TABLE_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/backend.h"

namespace latticed {

// A chunk to set.
struct NewChunk {
  uint64_t revision = 0;  // at which its bytes or the patterns of its patches last changed
  SharedBytes data;       // below 4 GiB
  VertexDigest digest;    // of the vertices that `data` encodes
};

// A chunk of a table, until it is set anew.
struct SnapshotChunk {
  uint64_t revision;
  std::span<const uint8_t> data;
  VertexDigest digest;
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

  // The most bytes of a table, without those of the chunks.
  [[nodiscard]] static uint64_t MostBytes(size_t size);

  // Returns a table of the same chunks. Set must not be called on this one afterwards.
  [[nodiscard]] ChunkTable Share() const;

  size_t size() const { return size_; }
  SnapshotChunk operator[](size_t chunk) const {
    return groups_[chunk / kGroup].chunks->At(chunk % kGroup);
  }
  // The chunk's data, with their owner.
  [[nodiscard]] SharedBytes Data(size_t chunk) const;
  void Set(size_t chunk, const NewChunk& to);
  // Copies the chunk's data out of their block.
  void CopyData(size_t chunk);
  // Keeps the bytes and the revision. A chunk that has the digest already stays shared.
  void SetDigest(size_t chunk, const VertexDigest& to);
  // The chunks with a later revision, ascending.
  [[nodiscard]] std::vector<uint32_t> ChangedAfter(uint64_t revision) const;
  // Every block once, and the bytes of chunks that are part of no block. Both take time by the number of
  // groups, and of chunks that are part of no block.
  [[nodiscard]] std::vector<BlockUse> Blocks() const;
  [[nodiscard]] uint64_t BytesOfNoBlock() const;

 private:
  static constexpr size_t kGroup = 256;
  // What keeps the bytes of some chunks. Null: free for another one.
  struct Owner {
    std::shared_ptr<const void> owner;
    uint64_t block_bytes = 0;
    uint64_t used = 0;    // bytes of its chunks
    uint32_t chunks = 0;  // of this group
  };
  struct Chunks {
    std::array<uint64_t, kGroup> revisions = {};
    std::array<const uint8_t*, kGroup> data = {};
    std::array<uint32_t, kGroup> sizes = {};
    std::array<VertexDigest, kGroup> digests = {};
    std::array<uint8_t, kGroup> owner_of = {};  // among `owners`
    std::vector<Owner> owners;                  // of chunks with data
    uint64_t newest_revision = 0;               // or later

    SnapshotChunk At(size_t i) const { return {revisions[i], {data[i], sizes[i]}, digests[i]}; }
    void SetData(size_t i, const SharedBytes& to);
    size_t OwnerFor(const SharedBytes& data);
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
