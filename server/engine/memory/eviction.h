// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chooses who gives memory back when somebody else needs it.
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

// Something that holds memory and can be made again.
struct EvictionCandidate {
  uint64_t bytes = 0;  // how many its eviction frees; 0: it is in use
  absl::Time last_use;
};

// Returns the places of those to evict so that `bytes` become free, the least recently used first. It is
// empty when all of them together hold fewer: nothing is evicted for a request that cannot be served. 0
// bytes mean that the missing bytes are not known; then one is evicted.
[[nodiscard]] std::vector<size_t> ChooseVictims(std::span<const EvictionCandidate> candidates,
                                                uint64_t bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_MEMORY_EVICTION_H_
