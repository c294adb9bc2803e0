// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/edge_order.h"

#include <algorithm>

namespace latticed {

std::vector<uint32_t> FirstEdges(const DeformPlan& plan) {
  std::vector<uint32_t> first{0};
  first.reserve(plan.chunk_count() + 1);
  uint32_t used = 0;  // edges so far: a new one has this number
  for (size_t chunk = 0; chunk < plan.chunk_count(); ++chunk) {
    const auto [begin, end] = plan.ChunkPatches(chunk);
    for (size_t p = begin; p < end; ++p) {
      for (const uint32_t edge : plan.patches[p].edge) used = std::max(used, edge + 1);
    }
    first.push_back(used);
  }
  return first;
}

}  // namespace latticed
