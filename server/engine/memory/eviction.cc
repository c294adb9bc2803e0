// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/memory/eviction.h"

#include <algorithm>

namespace latticed {

std::vector<size_t> ChooseVictims(std::span<const EvictionCandidate> candidates, uint64_t bytes) {
  std::vector<size_t> order;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].bytes > 0) order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, [&](size_t i) { return candidates[i].last_use; });
  std::vector<size_t> victims;
  uint64_t freed = 0;
  for (const size_t i : order) {
    victims.push_back(i);
    freed += candidates[i].bytes;
    if (freed >= bytes) return victims;
  }
  return {};
}

}  // namespace latticed
