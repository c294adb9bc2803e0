// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/feature_uses.h"

#include <array>

#include "core/base/limits.h"

namespace latticed {
namespace {

using kernels::FeatureUses;

// Numbers corners or edges in order of first use. A corner or edge on a seam counts once for each side of
// the seam, because each side has its own owner. It is a hash table with open addressing; entries of earlier
// chunks count as free, so nothing is ever cleared.
class Numbering {
 public:
  struct Number {
    uint32_t number;
    bool is_first;
  };
  void Clear() {
    ++chunk_;
    count_ = 0;
  }
  Number Of(uint32_t entity, bool outside) {
    const uint64_t key = uint64_t{entity} << 1 | uint64_t{outside};
    for (size_t i = key * kSpread >> (64 - kTableBits);; i = (i + 1) % kTable) {
      Entry& entry = table_[i];
      if (entry.chunk == chunk_ && entry.key == key) return {entry.number, false};
      if (entry.chunk == chunk_) continue;
      entry = {.key = key, .chunk = chunk_, .number = count_};
      return {count_++, true};
    }
  }

 private:
  struct Entry {
    uint64_t key = 0;
    uint32_t chunk = 0;  // 0: none yet
    uint32_t number = 0;
  };
  static constexpr int kTableBits = 8;
  static constexpr size_t kTable = size_t{1} << kTableBits;
  static_assert(kTable > 2 * 3 * limits::kPatchesPerChunk, "at most half full");
  static constexpr uint64_t kSpread = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio

  std::array<Entry, kTable> table_;
  uint32_t chunk_ = 0, count_ = 0;
};

}  // namespace

std::vector<FeatureUses> PackFeatureUses(const DeformPlan& plan) {
  std::vector<FeatureUses> uses(plan.patches.size());
  Numbering edges, corners;
  std::vector<bool> runs_back;  // for each edge of the chunk: its first use runs backwards
  for (size_t chunk = 0; chunk < plan.chunk_count(); ++chunk) {
    edges.Clear();
    corners.Clear();
    runs_back.clear();
    const auto [first, last] = plan.ChunkPatches(chunk);
    for (size_t p = first; p < last; ++p) {
      const Patch& patch = plan.patches[p];
      const bool outside = patch.box == plan.outside_box();
      for (uint32_t slot = 0; slot < 3; ++slot) {
        const auto edge = edges.Of(patch.edge[slot], outside);
        if (edge.is_first) runs_back.push_back(patch.edge_reversed[slot]);
        const bool reversed = patch.edge_reversed[slot] != runs_back[edge.number];
        const auto corner = corners.Of(patch.vertex[slot], outside);
        uses[p].edges |= (edge.number | uint32_t{reversed} << 7 | uint32_t{edge.is_first} << 8)
                         << (9 * slot);
        uses[p].corners |= (corner.number | uint32_t{corner.is_first} << 7) << (8 * slot);
      }
    }
  }
  return uses;
}

}  // namespace latticed
