// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the fused kernel reads of a lattice for each chunk: the knot boxes of its patches, the boxes that
// own the patches' corners and edges (but not the outside box), and the seams that these lie on.
//
// Threads  immutable
#ifndef LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_
#define LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class ChunkNeeds {
 public:
  explicit ChunkNeeds(const DeformPlan& plan);

  // In ascending order, each once.
  std::span<const uint32_t> Boxes(uint32_t chunk) const { return boxes_.Of(chunk); }
  std::span<const uint32_t> Seams(uint32_t chunk) const { return seams_.Of(chunk); }
  size_t MemoryBytes() const { return boxes_.MemoryBytes() + seams_.MemoryBytes(); }

 private:
  // A list of numbers for each chunk, one list after the other.
  class Lists {
   public:
    // Adds the next chunk's numbers, which may be in any order and repeat. Empties `numbers`.
    void Add(std::vector<uint32_t>& numbers);
    std::span<const uint32_t> Of(uint32_t chunk) const {
      return std::span(numbers_).subspan(first_[chunk], first_[chunk + 1] - first_[chunk]);
    }
    size_t MemoryBytes() const { return (first_.size() + numbers_.size()) * sizeof(uint32_t); }

   private:
    std::vector<uint32_t> first_{0};  // where each chunk's list begins in numbers_, and the end
    std::vector<uint32_t> numbers_;
  };

  Lists boxes_, seams_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_CHUNK_NEEDS_H_
