// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/adaptive_evaluator.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/adaptive/edge_levels.h"
#include "core/cpu/adaptive/adaptive_points.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/view/view_layout.h"

namespace latticed {

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
      bounder_(plan_, arena),
      levels_(plan_->plan),
      all_chunks_(plan_->plan->chunk_count()) {
  std::iota(all_chunks_.begin(), all_chunks_.end(), 0u);
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
  frame_.emplace(Frame{.control_points = control_points,
                       .box = box,
                       .chunks = chunks,
                       .boxes = fused::FrameBoxes(*plan_, control_points),
                       .changed = {}});
  bounder_.Bound(chunks, control_points, frame_->boxes,
                 [this](size_t patch, const CurvatureBounds<float>& bounds) {
                   levels_.SetBounds(patch, bounds);
                 });
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
  AdaptivePoints points(*plan_, spec_, {frame.control_points, frame.box, *levels_.codes()},
                        frame_->boxes);
  points.Evaluate(Union(frame.chunks, also_changed_), arena_, vertices);
  frame_.reset();
}

PatternCodes AdaptiveEvaluator::Patterns() const {
  const auto codes = levels_.codes();
  return {codes, *codes};
}

size_t AdaptiveEvaluator::MemoryBytes() const {
  return levels_.MemoryBytes() + bounder_.MemoryBytes() + all_chunks_.size() * sizeof(uint32_t);
}

}  // namespace latticed
