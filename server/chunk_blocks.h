// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The blocks that chunks are parts of. A backend may encode many chunks into one block
// (SharedBytes::block_bytes), which stays as long as one of them is used: after an edit of a corner
// a snapshot would hold two blocks for one block's worth of chunks, after a hundred edits any number.
// So chunks are copied out of blocks most of which nobody uses.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_CHUNK_BLOCKS_H_
#define LATTICED_SERVER_CHUNK_BLOCKS_H_

#include <cstdint>
#include <vector>

#include "server/snapshot.h"

namespace latticed {

// Bytes of the blocks that the chunks are parts of, each once.
[[nodiscard]] uint64_t BlockBytes(const std::vector<SnapshotChunk>& chunks);

// Copies out of every block the chunks that are less than half of it, so that the blocks left are at
// most twice their chunks.
void LeaveEmptyBlocks(std::vector<SnapshotChunk>& chunks);

// To be called with each new snapshot: looks through it and does so where blocks may have grown to
// four times the chunks, so seldom that it costs each byte that was encoded the same. `made`: the
// bytes of blocks that were added since `snapshot.block_bytes` was right.
void KeepBlocksFew(uint64_t made, Snapshot& snapshot);

}  // namespace latticed

#endif  // LATTICED_SERVER_CHUNK_BLOCKS_H_
