// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks that something must still be done with: some, or all of a plan that may change meanwhile.
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_SET_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_SET_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace latticed {

class ChunkSet {
 public:
  static ChunkSet All() {
    ChunkSet set;
    set.AddAll();
    return set;
  }

  void Add(std::span<const uint32_t> chunks);
  // Of whatever plan Take will speak of.
  void AddAll() { all_ = true; }
  // Those below `count`, ascending; the set is empty then. What another plan left in it beyond
  // `count` is forgotten: a change of plan adds all.
  [[nodiscard]] std::vector<uint32_t> Take(size_t count);

  bool all() const { return all_; }
  // How many Take would give.
  [[nodiscard]] size_t Count(size_t count) const;

 private:
  bool all_ = false;
  std::vector<bool> some_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_SET_H_
