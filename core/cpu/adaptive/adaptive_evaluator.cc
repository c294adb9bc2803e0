// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/adaptive_evaluator.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/adaptive/edge_levels.h"
#include "core/base/status_macros.h"
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

AdaptiveEvaluator::AdaptiveEvaluator(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                                     std::unique_ptr<AdaptiveSurface> surface, CpuArena& arena)
    : spec_(spec),
      arena_(arena),
      most_points_(plan->patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments))),
      surface_(std::move(surface)),
      levels_(plan),
      all_chunks_(plan->chunk_count()) {
  std::iota(all_chunks_.begin(), all_chunks_.end(), 0u);
}

absl::Status AdaptiveEvaluator::Evaluate(std::span<const Vec3d> control_points,
                                         const QuantisationBox& box,
                                         std::span<const uint32_t> chunks,
                                         ChunkVertices& vertices) {
  LATTICED_RETURN_IF_ERROR(Bound(control_points, box, chunks));
  ToleranceSteps steps(spec_.tolerance, box, GridBits(spec_));
  Choose(steps.curvature());
  while (levels_.point_count() > most_points_) {
    steps.Double();
    Choose(steps.curvature());
  }
  return Finish(vertices);
}

absl::Status AdaptiveEvaluator::Bound(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box,
                                      std::span<const uint32_t> chunks) {
  frame_.emplace(Frame{.box = box, .chunks = chunks, .changed = {}});
  surface_->Begin(control_points);
  return surface_->Bound(chunks, [this](size_t patch, const CurvatureBounds<float>& bounds) {
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

absl::Status AdaptiveEvaluator::Finish(ChunkVertices& vertices) {
  const Frame& frame = *frame_;
  certified_error_ = levels_.LargestError() + PointError(frame.box, GridBits(spec_));
  also_changed_.clear();
  std::ranges::set_difference(frame.changed, frame.chunks, std::back_inserter(also_changed_));
  const absl::Status status =
      surface_->Write(Union(frame.chunks, also_changed_), *levels_.codes(), frame.box, vertices);
  frame_.reset();
  return status;
}

PatternCodes AdaptiveEvaluator::Patterns() const {
  const auto codes = levels_.codes();
  return {codes, *codes};
}

size_t AdaptiveEvaluator::MemoryBytes() const {
  return levels_.MemoryBytes() + surface_->MemoryBytes() + all_chunks_.size() * sizeof(uint32_t);
}

}  // namespace latticed
