// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/shared_edges.h"

namespace latticed {
namespace {

// The slice of each patch's edges in turn.
class EdgesOfSlices {
 public:
  EdgesOfSlices(const DeformPlan& plan, std::span<const uint32_t> first_chunks)
      : plan_(plan), first_chunks_(first_chunks) {}

  template <class F>
  void ForEach(size_t slice, const F& f) const {
    const size_t first = plan_.ChunkPatches(first_chunks_[slice])[0];
    const size_t last = slice + 1 < first_chunks_.size()
                            ? plan_.ChunkPatches(first_chunks_[slice + 1])[0]
                            : plan_.patches.size();
    for (size_t p = first; p < last; ++p) {
      for (const uint32_t edge : plan_.patches[p].edge) f(edge);
    }
  }

 private:
  const DeformPlan& plan_;
  const std::span<const uint32_t> first_chunks_;
};

}  // namespace

SharedEdges SharedEdges::Find(const DeformPlan& plan, std::span<const uint32_t> first_chunks) {
  const EdgesOfSlices edges(plan, first_chunks);
  SharedEdges shared;
  std::vector<uint32_t> first_user(plan.edges.size(), kNoIndex);
  std::vector<bool> is_shared(plan.edges.size());
  for (uint32_t slice = 0; slice < first_chunks.size(); ++slice) {
    edges.ForEach(slice, [&](uint32_t edge) {
      if (first_user[edge] == kNoIndex) first_user[edge] = slice;
      if (first_user[edge] != slice) is_shared[edge] = true;
    });
  }
  for (size_t slice = 0; slice < first_chunks.size(); ++slice) {
    std::vector<bool> is_used(plan.edges.size());
    edges.ForEach(slice, [&](uint32_t edge) { is_used[edge] = true; });
    Slice& of_slice = shared.slices.emplace_back();
    uint32_t in_slice = 0, number = 0;  // SlicePlan numbers the edges in use in the plan's order
    for (size_t edge = 0; edge < plan.edges.size(); ++edge) {
      if (is_used[edge] && is_shared[edge]) {
        of_slice.edges.push_back(in_slice);
        of_slice.numbers.push_back(number);
      }
      in_slice += uint32_t{is_used[edge]};
      number += uint32_t{is_shared[edge]};
    }
    shared.count = number;
  }
  return shared;
}

size_t SharedEdges::MemoryBytes() const {
  size_t bytes = 0;
  for (const Slice& slice : slices) bytes += 2 * slice.edges.size() * sizeof(uint32_t);
  return bytes;
}

}  // namespace latticed
