// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan in the form that the fused kernel reads: the patches of each knot box in groups of 16, and the edges and
// corners that a group takes from another box.
//
//   group    patches first_patch … first_patch + lanes - 1, all of one box
//   feature  an edge or corner that is evaluated in one box for the patches of others; 16 to a feature group
//   fix      "lane l of this group takes edge or corner `slot` from feature f". On a knot plane it always applies. On
//            a seam it takes the outside's feature while the seam is attached, and the inside's while it is not.
//
// Threads  immutable after construction
#ifndef LATTICED_CORE_CPU_FUSED_FUSED_LAYOUT_H_
#define LATTICED_CORE_CPU_FUSED_FUSED_LAYOUT_H_

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/cpu/fused/box_polynomials.h"
#include "core/cpu/fused/fused_weights.h"
#include "core/cpu/fused/kernel/fused_kernel.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed::fused {

struct Group {
  uint32_t box = 0;
  uint32_t first_patch = 0;
  uint32_t lanes = 0;
  uint32_t first_fix = 0, last_fix = 0;  // half open
};

// Features are numbered feature_group * 16 + lane. With kNoIndex the group keeps what it computed itself.
struct Fix {
  uint8_t lane = 0;
  uint8_t slot = 0;  // corner or edge 0 … 2
  bool is_edge = false;
  bool reversed = false;  // the feature runs against the patch's edge
  uint32_t seam = kNoIndex;
  uint32_t attached = kNoIndex;  // used while the seam is attached
  uint32_t detached = kNoIndex;  // used otherwise, and where there is no seam
};

template <typename LanesType>
struct FeatureSet {
  std::vector<LanesType> groups;
  std::vector<uint32_t> boxes;  // of each group
};

class FusedLayout {
 public:
  FusedLayout(std::shared_ptr<const DeformPlan> plan, const BoxPolynomials& polynomials);

  std::vector<Group> groups;
  std::vector<PatchLanes> patches;  // one per group
  std::vector<SmoothLanes> smooth;  // one per group
  std::vector<Fix> fixes;
  FeatureSet<EdgeLanes> edges;
  FeatureSet<CornerLanes> corners;
  FusedWeights weights;
  std::vector<uint32_t> group_of_patch;

  uint64_t MemoryBytes() const;

 private:
  void PackGroups(uint32_t box);
  void PackLane(size_t group, size_t lane, uint32_t patch);
  void PackSmooth(size_t group, size_t lane, uint32_t patch, Vec3d facet, Vec3d along,
                  Vec3d across);
  void AddFixes(uint32_t patch, uint8_t lane);
  uint32_t EdgeFeature(uint32_t edge, uint32_t box);
  uint32_t CornerFeature(uint32_t vertex, uint32_t box);

  std::shared_ptr<const DeformPlan> plan_;
  const BoxPolynomials& polynomials_;
  // Feature numbers by (edge or vertex, box), and each box's last feature group with its number of used lanes.
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> edge_features_, corner_features_;
  std::map<uint32_t, std::pair<uint32_t, uint32_t>> open_edges_, open_corners_;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_LAYOUT_H_
