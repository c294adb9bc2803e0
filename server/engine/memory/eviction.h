// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who gives memory back when another needs it.
//
// Threads  pure
#ifndef LATTICED_SERVER_ENGINE_MEMORY_EVICTION_H_
#define LATTICED_SERVER_ENGINE_MEMORY_EVICTION_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/time/time.h"

namespace latticed {

// A holder of memory that can be made again.
struct EvictionCandidate {
  uint64_t bytes = 0;  // that its eviction frees; 0: it is in use
  absl::Time last_use;
};

// Places of those to evict so that `bytes` come free, the least recently used first. Empty where all
// together have fewer: nobody is evicted for a request that cannot be served. 0 bytes, which says
// that nobody knows how many are missing, evicts one.
[[nodiscard]] std::vector<size_t> ChooseVictims(std::span<const EvictionCandidate> candidates,
                                                uint64_t bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_EVICTION_H_
