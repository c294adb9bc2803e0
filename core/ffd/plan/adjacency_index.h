// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A map from (vertex, key) to numbers, stored by vertex. Neighbours in the mesh are then near in
// memory; a hash table would miss the cache at every edge of a large mesh.
//
// A vertex has its first kMostAtVertex keys in a list; further keys are hashed. Look-up takes
// constant time even at the apex of a fan of a million triangles.
//
// Threads  one thread at a time
#ifndef LATTICED_CORE_FFD_PLAN_ADJACENCY_INDEX_H_
#define LATTICED_CORE_FFD_PLAN_ADJACENCY_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"

namespace latticed {

class AdjacencyIndex {
 public:
  static constexpr size_t kMostAtVertex = 32;

  // Reserves memory for this many vertices and keys. More may be added.
  void Reserve(size_t vertices, size_t keys) {
    first_.resize(vertices, kNone);
    entries_.reserve(keys);
  }

  // Returns the number of (vertex, key) and whether the pair is new. A new pair gets `number`.
  std::pair<uint32_t, bool> TryEmplace(uint32_t vertex, uint64_t key, uint32_t number) {
    return Place(vertex, key, number, [&]() -> std::pair<uint32_t, bool> {
      const auto [it, added] = rest_.try_emplace({vertex, key}, number);
      return {it->second, added};
    });
  }

  // The same without the hashed keys: one that the list of its vertex has no room for is new each time. After Reserve,
  // this takes no memory.
  std::pair<uint32_t, bool> TryEmplaceInList(uint32_t vertex, uint64_t key, uint32_t number) {
    return Place(vertex, key, number, [&] { return std::pair(number, true); });
  }

  // What Reserve takes.
  static constexpr uint64_t ReservedBytes(uint64_t vertices, uint64_t keys) {
    return vertices * sizeof(uint32_t) + keys * sizeof(Entry);
  }

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  struct Entry {
    uint64_t key;
    uint32_t number, next;
  };

  template <typename IfFull>
  std::pair<uint32_t, bool> Place(uint32_t vertex, uint64_t key, uint32_t number, IfFull if_full) {
    if (vertex >= first_.size()) first_.resize(vertex + size_t{1}, kNone);
    size_t count = 0;
    for (uint32_t i = first_[vertex]; i != kNone; i = entries_[i].next, ++count) {
      if (entries_[i].key == key) return {entries_[i].number, false};
    }
    if (count == kMostAtVertex) return if_full();
    entries_.push_back({key, number, first_[vertex]});
    first_[vertex] = static_cast<uint32_t>(entries_.size() - 1);
    return {number, true};
  }

  std::vector<uint32_t> first_;  // entry, by vertex
  std::vector<Entry> entries_;
  absl::flat_hash_map<std::pair<uint32_t, uint64_t>, uint32_t> rest_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_ADJACENCY_INDEX_H_
