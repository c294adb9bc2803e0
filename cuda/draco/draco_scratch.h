// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The working memory that encoding some chunks takes: about 21 bytes a point with normals, 44 of sparse chunks, and 12
// bytes a table entry.
//
// Threads  pure
#ifndef LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_
#define LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "cuda/draco/draco_kernels.h"

namespace latticed {

// Counts what the chunks of an encoding need.
class DracoSizes {
 public:
  // Of `work`, only the properties of the view.
  explicit DracoSizes(const kernels::DracoWork& work);

  // Adds a chunk, and returns StreamChunk::scratch_at.
  uint32_t Add(uint32_t points) {
    const uint32_t first_group = groups_;
    // No less than what its streams take, each rounded up: a sum of floor((n + 15) / 16) is at most floor of the sum.
    groups_ += (points * values_ + room_) / kernels::kSymbolsAWord;
    ++chunks_;
    points_ += points;
    if (points > kernels::kMostRankedPoints) {
      ++large_;
      large_points_ += points;
    } else {
      most_of_others_ = std::max(most_of_others_, points);
    }
    return first_group;
  }
  size_t groups() const { return groups_; }

  // Sets the number of chunks in `work`, whether they are ranked, and the number of table entries. `entry_room`: that of the
  // entries, never less than one chunk may need; 0: what most chunks need.
  void SetSizes(uint32_t entry_room, kernels::DracoWork& work) const;

 private:
  uint32_t values_ = 0,
           room_ = 0;  // symbols of a point in all streams; what rounding a chunk's up may take
  uint32_t groups_ = 0, chunks_ = 0, large_ = 0, most_of_others_ = 0;
  uint64_t points_ = 0, large_points_ = 0;
};

// Divides a block among the pointers to working memory in `work`, which has the sizes, and returns the bytes of the block.
// They are known without it, if it is null.
size_t DivideDracoScratch(uint8_t* block, size_t groups, kernels::DracoWork& work);

}  // namespace latticed

#endif  // LATTICED_CUDA_DRACO_DRACO_SCRATCH_H_
