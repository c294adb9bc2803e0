// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A set of chunks that still have to be evaluated: some, or all of a plan that may change meanwhile.
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

  // `chunks` must be ascending.
  void Add(std::span<const uint32_t> chunks);
  // All chunks of the plan that the next Take is about.
  void AddAll() { all_ = true; }
  // Returns the chunks below `count`, ascending, and empties the set. Numbers from `count` on are those of
  // an earlier plan and are dropped: a change of plan adds all chunks.
  [[nodiscard]] std::vector<uint32_t> Take(size_t count);

  bool all() const { return all_; }
  // How many chunks Take would return.
  [[nodiscard]] size_t Count(size_t count) const;

 private:
  bool all_ = false;
  std::vector<uint32_t> some_;  // ascending
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_SET_H_
