// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The blocks that chunks are parts of. A backend may encode many chunks into one block
// (SharedBytes::block_bytes), which stays as long as one of them is used: after an edit of a corner
// a snapshot would hold two blocks for one block's worth of chunks, after a hundred edits any number.
// So chunks are copied out of blocks most of which nobody uses.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_

#include <cstdint>

#include "server/engine/render/snapshot.h"

namespace latticed {

// Bytes that the chunks keep: of the blocks that they are parts of, each once, and of those that are
// parts of none.
[[nodiscard]] uint64_t HeldBytes(const ChunkTable& chunks);

// Copies out of every block the chunks that are less than half of it, so that the blocks left are at
// most twice their chunks. Sets snapshot.held_bytes.
void LeaveEmptyBlocks(Snapshot& snapshot);

// To be called with each new snapshot: does so where blocks have grown to four times their chunks, so
// seldom that it costs each byte that was encoded the same. Sets snapshot.held_bytes.
void KeepBlocksFew(Snapshot& snapshot);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_
