// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/chunk_needs.h"

#include <algorithm>

namespace latticed {

ChunkNeeds::ChunkNeeds(const DeformPlan& plan) {
  std::vector<uint32_t> boxes, seams;
  for (size_t chunk = 0; chunk < plan.chunk_count(); ++chunk) {
    const auto [first, last] = plan.ChunkPatches(chunk);
    for (size_t p = first; p < last; ++p) {
      const Patch& patch = plan.patches[p];
      // The identity map gives all points of patches outside.
      if (patch.box == plan.outside_box()) continue;
      boxes.push_back(patch.box);
      for (size_t i = 0; i < 3; ++i) {
        const PlanVertex& corner = plan.vertices[patch.vertex[i]];
        const PlanEdge& edge = plan.edges[patch.edge[i]];
        boxes.insert(boxes.end(), {corner.box, edge.box});
        if (corner.seam != kNoIndex) seams.push_back(corner.seam);
        if (edge.seam != kNoIndex) seams.push_back(edge.seam);
      }
    }
    boxes_.Add(boxes);
    seams_.Add(seams);
  }
}

void ChunkNeeds::Lists::Add(std::vector<uint32_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  numbers_.insert(numbers_.end(), numbers.begin(), numbers.end());
  first_.push_back(static_cast<uint32_t>(numbers_.size()));
  numbers.clear();
}

}  // namespace latticed
