// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/shared_edges.h"

#include <utility>

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
  std::vector<uint32_t> last_user(plan.edges.size(), kNoIndex);  // a slice
  std::vector<uint32_t> number(plan.edges.size(), kNoIndex);     // of a shared edge; 0 at first
  for (uint32_t slice = 0; slice < first_chunks.size(); ++slice) {
    edges.ForEach(slice, [&](uint32_t edge) {
      const uint32_t before = std::exchange(last_user[edge], slice);
      if (before != kNoIndex && before != slice) number[edge] = 0;
    });
  }
  for (uint32_t edge = 0; edge < number.size(); ++edge) {
    if (number[edge] == kNoIndex) continue;
    number[edge] = static_cast<uint32_t>(shared.edges.size());
    shared.edges.push_back(edge);
  }
  for (size_t slice = 0; slice < first_chunks.size(); ++slice) {
    Slice& of_slice = shared.slices.emplace_back();
    std::vector<bool> is_used(plan.edges.size());
    uint32_t in_slice = 0;  // SlicePlan numbers edges in this order
    edges.ForEach(slice, [&](uint32_t edge) {
      if (is_used[edge]) return;
      is_used[edge] = true;
      if (number[edge] != kNoIndex) {
        of_slice.edges.push_back(in_slice);
        of_slice.numbers.push_back(number[edge]);
      }
      ++in_slice;
    });
  }
  return shared;
}

size_t SharedEdges::MemoryBytes() const {
  size_t bytes = edges.size() * sizeof(uint32_t);
  for (const Slice& slice : slices) bytes += 2 * slice.edges.size() * sizeof(uint32_t);
  return bytes;
}

}  // namespace latticed
