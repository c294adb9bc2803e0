// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The blocks that chunks are parts of. A backend may encode many chunks into one block
// (SharedBytes::block_bytes), which stays in memory as long as one of its chunks is used. After an edit of
// a few chunks a snapshot would hold two blocks for one block's worth of chunks, and after a hundred edits
// any number. So chunks are copied out of blocks that are mostly unused.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_

#include <cstdint>

#include "server/engine/render/snapshot.h"

namespace latticed {

// The bytes that the chunks keep in memory: those of their blocks, each counted once, and those of chunks
// that are part of no block.
[[nodiscard]] uint64_t HeldBytes(const ChunkTable& chunks);

// Copies the chunks out of every block of which they are less than half. Blocks then take at most twice
// the bytes of their chunks. Sets snapshot.held_bytes.
void LeaveEmptyBlocks(Snapshot& snapshot);

// Called with each new snapshot. It does the same once blocks have grown to four times their chunks, so
// copying costs a constant for each encoded byte. Sets snapshot.held_bytes.
void KeepBlocksFew(Snapshot& snapshot);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_BLOCKS_H_
