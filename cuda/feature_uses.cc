// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/feature_uses.h"

#include <algorithm>
#include <utility>

namespace latticed {
namespace {

using kernels::FeatureUses;

// Numbers in order of first use. A seam's points have an owner on either side of it.
class Numbering {
 public:
  struct Number {
    uint32_t number;
    bool is_first;
  };
  void Clear() { keys_.clear(); }
  Number Of(uint32_t entity, bool outside) {
    const std::pair key(entity, outside);
    const auto found = std::find(keys_.begin(), keys_.end(), key);
    const auto number = static_cast<uint32_t>(found - keys_.begin());
    const bool is_first = found == keys_.end();
    if (is_first) keys_.push_back(key);
    return {number, is_first};
  }

 private:
  std::vector<std::pair<uint32_t, bool>> keys_;  // at most 96
};

}  // namespace

std::vector<FeatureUses> PackFeatureUses(const DeformPlan& plan) {
  std::vector<FeatureUses> uses(plan.patches.size());
  Numbering edges, corners;
  std::vector<bool> runs_back;  // of the first use of each edge of the chunk
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
