// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A bounding-volume hierarchy of a plan's patches, in parameter space, one tree for each knot box.
// It serves searches of the deformed surface. Control points do not change it, so one tree serves
// every revision.
//
//   leaf    kLeafPatches consecutive patches of one knot box; the Morton order of the plan keeps
//           them together
//   node    kFanOut consecutive nodes of the level below, or fewer
//
// Layout   nodes of a level are consecutive, and every node comes after its children
// Errors   none
// Threads  immutable
#ifndef LATTICED_CORE_FFD_PICK_PATCH_TREE_H_
#define LATTICED_CORE_FFD_PICK_PATCH_TREE_H_

#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class PatchTree {
 public:
  static constexpr uint32_t kLeafPatches = 16;
  static constexpr uint32_t kFanOut = 4;

  struct Node {
    Vec3d lower, upper;  // parameters; world units in the outside box
    uint32_t box = 0;    // of the plan
    uint32_t first = 0;  // first patch of a leaf, else first node
    uint32_t count = 0;
    bool leaf = false;
  };

  explicit PatchTree(const DeformPlan& plan);

  const Node& node(uint32_t index) const { return nodes_[index]; }
  // One for each knot box that holds patches.
  const std::vector<uint32_t>& roots() const { return roots_; }
  size_t MemoryBytes() const;

 private:
  std::vector<Node> nodes_;
  std::vector<uint32_t> roots_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PICK_PATCH_TREE_H_
