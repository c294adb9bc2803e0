// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts of a lattice that the fused kernel reads for each chunk: the knot boxes of its patches
// and the boxes that own their corners and edges, without the outside box; and the seams of these
// corners and edges.
//
// Threads  immutable
#ifndef LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_
#define LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/deform_plan.h"

namespace latticed {

class ChunkNeeds {
 public:
  explicit ChunkNeeds(const DeformPlan& plan);

  // Ascending, each once.
  std::span<const uint32_t> Boxes(uint32_t chunk) const { return boxes_.Of(chunk); }
  std::span<const uint32_t> Seams(uint32_t chunk) const { return seams_.Of(chunk); }
  size_t MemoryBytes() const { return boxes_.MemoryBytes() + seams_.MemoryBytes(); }

 private:
  // Numbers by chunk, one list behind the other.
  class Lists {
   public:
    // The next chunk's, in any order and more than once; leaves none of them there.
    void Add(std::vector<uint32_t>& numbers);
    std::span<const uint32_t> Of(uint32_t chunk) const {
      return std::span(numbers_).subspan(first_[chunk], first_[chunk + 1] - first_[chunk]);
    }
    size_t MemoryBytes() const { return (first_.size() + numbers_.size()) * sizeof(uint32_t); }

   private:
    std::vector<uint32_t> first_{0};  // of each chunk in numbers_, and the end
    std::vector<uint32_t> numbers_;
  };

  Lists boxes_, seams_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_
