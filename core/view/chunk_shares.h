// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How the chunks of a plan are shared out among devices, in runs.
//
//   equal counts, where every device has room for an equal share; else in proportion to the room
//
// Patches cost alike whatever they hold, so equal counts are equal times.
// Threads  pure
#ifndef LATTICED_CORE_VIEW_CHUNK_SHARES_H_
#define LATTICED_CORE_VIEW_CHUNK_SHARES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace latticed {

// One run for each number of free bytes: run i is [result[i], result[i + 1]), and may be empty.
[[nodiscard]] std::vector<size_t> ShareChunks(size_t chunks, uint64_t bytes_per_chunk,
                                              std::span<const uint64_t> free_bytes);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_CHUNK_SHARES_H_
