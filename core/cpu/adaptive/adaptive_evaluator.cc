// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/adaptive_evaluator.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/adaptive/curvature_slack.h"
#include "core/adaptive/edge_levels.h"
#include "core/cpu/adaptive/adaptive_points.h"
#include "core/cpu/flush_denormals.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/view/view_layout.h"

namespace latticed {

using fused::FusedLayout;
using fused::Group;

namespace {

std::vector<uint32_t> Union(std::span<const uint32_t> a, std::span<const uint32_t> b) {
  std::vector<uint32_t> both;
  std::ranges::set_union(a, b, std::back_inserter(both));
  return both;
}

}  // namespace

AdaptiveEvaluator::AdaptiveEvaluator(std::shared_ptr<const fused::FusedPlan> plan,
                                     const ViewSpec& spec, CpuArena& arena)
    : plan_(std::move(plan)),
      spec_(spec),
      arena_(arena),
      most_points_(plan_->plan->patches.size() *
                   static_cast<uint64_t>(PointsPerPatch(spec.segments))),
      reach_(plan_->plan->boxes.size()),
      levels_(plan_->plan),
      all_chunks_(plan_->plan->chunk_count()) {
  std::iota(all_chunks_.begin(), all_chunks_.end(), 0u);
  MeasureReach();
}

void AdaptiveEvaluator::MeasureReach() {
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

void AdaptiveEvaluator::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                 std::span<const uint32_t> chunks, ChunkVertices& vertices) {
  Bound(control_points, box, chunks);
  ToleranceSteps steps(spec_.tolerance, box, GridBits(spec_));
  Choose(steps.curvature());
  while (levels_.point_count() > most_points_) {
    steps.Double();
    Choose(steps.curvature());
  }
  Finish(vertices);
}

void AdaptiveEvaluator::Bound(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) {
  const FusedLayout& layout = plan_->layout;
  frame_.emplace(Frame{.control_points = control_points,
                       .box = box,
                       .chunks = chunks,
                       .boxes = fused::FrameBoxes(*plan_, control_points),
                       .changed = {}});
  const std::vector<uint32_t> groups = GroupsToBound();
  fused::FrameBoxes& boxes = frame_->boxes;
  boxes.MakeNeeded(arena_);
  std::vector<std::array<float, 6>> slack(reach_.size());
  arena_.ForEach(reach_.size(), [&](size_t box_number) {
    const auto number = static_cast<uint32_t>(box_number);
    if (!boxes.IsMade(number)) return;
    slack[number] = plan_->polynomials.Slack(number, control_points, reach_[number]);
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
        levels_.SetBounds(group.first_patch + lane,
                          {{bounds[0][lane], bounds[1][lane], bounds[2][lane]},
                           {bounds[3][lane], bounds[4][lane], bounds[5][lane]}});
      }
    }
  });
}

std::vector<uint32_t> AdaptiveEvaluator::GroupsToBound() {
  const FusedLayout& layout = plan_->layout;
  const uint32_t outside = plan_->plan->outside_box();
  std::vector<uint32_t> groups;
  for (const uint32_t chunk : frame_->chunks) {
    const auto [first, last] = plan_->plan->ChunkPatches(chunk);
    for (uint32_t g = layout.group_of_patch[first]; g <= layout.group_of_patch[last - 1]; ++g) {
      if (layout.groups[g].box == outside || (!groups.empty() && groups.back() >= g)) continue;
      groups.push_back(g);
      frame_->boxes.Need(layout.groups[g].box);
    }
  }
  return groups;
}

void AdaptiveEvaluator::Choose(double curvature_tolerance) {
  // Bounds of the named chunks are new where the tolerance is that of the last evaluation.
  const bool is_same =
      std::exchange(curvature_tolerance_, curvature_tolerance) == curvature_tolerance;
  const auto changed =
      levels_.Update(is_same ? frame_->chunks : all_chunks_, curvature_tolerance, arena_);
  frame_->changed = Union(frame_->changed, changed);
}

void AdaptiveEvaluator::Finish(ChunkVertices& vertices) {
  const Frame& frame = *frame_;
  certified_error_ = levels_.LargestError() + PointError(frame.box, GridBits(spec_));
  also_changed_.clear();
  std::ranges::set_difference(frame.changed, frame.chunks, std::back_inserter(also_changed_));
  AdaptivePoints points(*plan_, spec_, {frame.control_points, frame.box, levels_.codes()},
                        frame_->boxes);
  points.Evaluate(Union(frame.chunks, also_changed_), arena_, vertices);
  frame_.reset();
}

std::span<const uint16_t> AdaptiveEvaluator::Patterns(uint32_t chunk) const {
  const auto [first, last] = plan_->plan->ChunkPatches(chunk);
  return levels_.codes().subspan(first, last - first);
}

size_t AdaptiveEvaluator::MemoryBytes() const {
  return levels_.MemoryBytes() + reach_.size() * sizeof(Vec3d) +
         all_chunks_.size() * sizeof(uint32_t);
}

}  // namespace latticed
