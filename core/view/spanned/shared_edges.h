// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The edges that patches of more than one slice of a plan use. Cuts follow the order of patches, so they are few.
//
// Threads  pure; immutable after construction
#ifndef LATTICED_CORE_VIEW_SPANNED_SHARED_EDGES_H_
#define LATTICED_CORE_VIEW_SPANNED_SHARED_EDGES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

struct SharedEdges {
  struct Slice {
    std::vector<uint32_t> edges;    // in the numbers of SlicePlan, ascending
    std::vector<uint32_t> numbers;  // of each: which of all shared edges it is
  };
  std::vector<uint32_t> edges;  // all that are shared, in the numbers of the plan, ascending
  std::vector<Slice> slices;

  // first_chunks: of each slice, ascending from 0.
  [[nodiscard]] static SharedEdges Find(const DeformPlan& plan,
                                        std::span<const uint32_t> first_chunks);
  [[nodiscard]] size_t MemoryBytes() const;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_SHARED_EDGES_H_
