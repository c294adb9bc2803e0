// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/pick/patch_tree.h"

#include <algorithm>

#include "core/base/bounds.h"

namespace latticed {
namespace {

PatchTree::Node MakeLeaf(const DeformPlan& plan, uint32_t box, uint32_t first, uint32_t count) {
  Bounds bounds;
  for (uint32_t p = first; p < first + count; ++p) {
    for (const uint32_t v : plan.patches[p].vertex) {
      const PlanVertex& vertex = plan.vertices[v];
      bounds.Extend(box == plan.outside_box() ? vertex.world : vertex.parameter);
    }
  }
  return {bounds.min, bounds.max, box, first, count, true};
}

}  // namespace

PatchTree::PatchTree(const DeformPlan& plan) {
  for (uint32_t box = 0; box < plan.boxes.size(); ++box) {
    const uint32_t end = plan.box_patches[box + 1];
    auto level = static_cast<uint32_t>(nodes_.size());
    for (uint32_t p = plan.box_patches[box]; p < end; p += kLeafPatches) {
      nodes_.push_back(MakeLeaf(plan, box, p, std::min(kLeafPatches, end - p)));
    }
    if (nodes_.size() == level) continue;
    while (nodes_.size() - level > 1) {
      const auto level_end = static_cast<uint32_t>(nodes_.size());
      for (uint32_t n = level; n < level_end; n += kFanOut) {
        Node node{.box = box, .first = n, .count = std::min(kFanOut, level_end - n)};
        Bounds bounds;
        for (uint32_t child = n; child < n + node.count; ++child) {
          bounds.Extend(nodes_[child].lower);
          bounds.Extend(nodes_[child].upper);
        }
        node.lower = bounds.min;
        node.upper = bounds.max;
        nodes_.push_back(node);
      }
      level = level_end;
    }
    roots_.push_back(level);
  }
  nodes_.shrink_to_fit();
}

size_t PatchTree::MemoryBytes() const {
  return sizeof(PatchTree) + nodes_.capacity() * sizeof(Node) +
         roots_.capacity() * sizeof(uint32_t);
}

}  // namespace latticed
