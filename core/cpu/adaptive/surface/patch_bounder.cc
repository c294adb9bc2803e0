// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/patch_bounder.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/adaptive/curvature_slack.h"
#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/adaptive/surface/raised_bounds.h"
#include "core/cpu/flush_denormals.h"

namespace latticed {

using fused::FusedLayout;
using fused::Group;

namespace {

// What rounding in double can take from a bound, as a share of the sum of the box's coefficients. As in
// core/adaptive/curvature_slack.h, the second derivatives of w G are bounded as if all terms had one sign: by at most
// 110,000 times this sum, 16 n (n + 1) by the degree and the steps, 1.5^n by the patch's reach of its box, 2 by the weight.
// Each product is rounded 150 times, which takes 1.9e-9.
constexpr double kWeightedBoundSlack = 2e-9;

}  // namespace

PatchBounder::PatchBounder(std::shared_ptr<const fused::FusedPlan> plan, CpuArena& arena)
    : plan_(std::move(plan)), arena_(arena), reach_(plan_->plan->boxes.size()) {
  MeasureReach();
  if (plan_->plan->is_weighted()) weighted_.emplace(plan_->plan);
}

void PatchBounder::MeasureReach() {
  const FusedLayout& layout = plan_->layout;
  for (size_t g = 0; g < layout.groups.size(); ++g) {
    const fused::PatchLanes& patches = layout.patches[g];
    Vec3d& reach = reach_[layout.groups[g].box];
    for (size_t lane = 0; lane < layout.groups[g].lanes; ++lane) {
      const auto vector = [&](const std::array<fused::Lanes, 3>& field) {
        return Vec3d{field[0][lane], field[1][lane], field[2][lane]};
      };
      const Vec3d own =
          PatchReach(vector(patches.center), vector(patches.along), vector(patches.across));
      for (int a = 0; a < 3; ++a) reach[a] = std::max(reach[a], own[a]);
    }
  }
}

void PatchBounder::Bound(std::span<const uint32_t> chunks, std::span<const Vec3d> control_points,
                         fused::FrameBoxes& boxes, Take take) const {
  const FusedLayout& layout = plan_->layout;
  const std::vector<uint32_t> groups = GroupsOf(chunks, boxes);
  boxes.MakeNeeded(arena_);
  if (weighted_.has_value()) return BoundWeighted(groups, control_points, take);
  std::vector<std::array<float, 6>> slack(reach_.size());
  arena_.ForEach(reach_.size(), [&](size_t i) {
    const auto box = static_cast<uint32_t>(i);
    if (!boxes.IsMade(box)) return;
    slack[box] = plan_->polynomials.Slack(box, control_points, reach_[box]);
  });
  arena_.ForRanges(groups.size(), 4, [&](size_t begin, size_t end) {
    const FlushDenormals flush;
    alignas(64) std::array<fused::Lanes, 6> bounds;
    for (size_t i = begin; i < end; ++i) {
      const Group& group = layout.groups[groups[i]];
      fused::BoundGroup({.degree = plan_->polynomials.degree(),
                         .box = &boxes[group.box],
                         .slack = slack[group.box],
                         .patches = &layout.patches[groups[i]],
                         .bounds = &bounds});
      for (size_t lane = 0; lane < group.lanes; ++lane) {
        take(group.first_patch + lane, {{bounds[0][lane], bounds[1][lane], bounds[2][lane]},
                                        {bounds[3][lane], bounds[4][lane], bounds[5][lane]}});
      }
    }
  });
}

void PatchBounder::BoundWeighted(std::span<const uint32_t> groups,
                                 std::span<const Vec3d> control_points, Take take) const {
  arena_.ForRanges(groups.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Group& group = plan_->layout.groups[groups[i]];
      const auto polynomial = weighted_->Polynomial(group.box, control_points);
      double slack = 0;
      for (const Vec3d c : polynomial) slack += kWeightedBoundSlack * Norm(c);
      for (size_t p = group.first_patch; p < group.first_patch + group.lanes; ++p) {
        take(p, RaisedBounds(weighted_->BoundPatch(p, polynomial), slack));
      }
    }
  });
}

std::vector<uint32_t> PatchBounder::GroupsOf(std::span<const uint32_t> chunks,
                                             fused::FrameBoxes& boxes) const {
  const FusedLayout& layout = plan_->layout;
  const uint32_t outside = plan_->plan->outside_box();
  std::vector<uint32_t> groups;
  for (const uint32_t chunk : chunks) {
    const auto [first, last] = plan_->plan->ChunkPatches(chunk);
    for (uint32_t g = layout.group_of_patch[first]; g <= layout.group_of_patch[last - 1]; ++g) {
      if (layout.groups[g].box == outside || (!groups.empty() && groups.back() >= g)) continue;
      groups.push_back(g);
      boxes.Need(layout.groups[g].box);
    }
  }
  return groups;
}

}  // namespace latticed
