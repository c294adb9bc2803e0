// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/tolerance_exchange.h"

#include <algorithm>
#include <utility>

#include "core/adaptive/edge_levels.h"
#include "core/adaptive/patch_curvature.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/view/view_layout.h"

namespace latticed {

ToleranceExchange::ToleranceExchange(const DeformPlan& plan, const ViewSpec& spec,
                                     std::shared_ptr<const SharedEdges> shared,
                                     std::vector<ToleranceSlice*> slices)
    : spec_(spec),
      most_points_(plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments))),
      shared_(std::move(shared)),
      slices_(std::move(slices)),
      largest_(shared_->edges.size()) {
  for (const SharedEdges::Slice& slice : shared_->slices) raised_.emplace_back(slice.edges.size());
}

absl::StatusOr<std::unique_ptr<ToleranceExchange>> ToleranceExchange::Create(
    const DeformPlan& plan, const ViewSpec& spec, std::shared_ptr<const SharedEdges> shared,
    std::span<DeformView* const> views) {
  std::vector<ToleranceSlice*> slices;
  for (DeformView* const view : views) {
    slices.push_back(view->tolerance_slice());
    if (slices.back() != nullptr) continue;
    return error::InvalidField("view.tolerance", "these devices cannot share it", "UNSUPPORTED");
  }
  std::unique_ptr<ToleranceExchange> exchange(
      new ToleranceExchange(plan, spec, std::move(shared), std::move(slices)));
  LATTICED_RETURN_IF_ERROR(exchange->Share());
  return exchange;
}

absl::Status ToleranceExchange::Share() {
  const std::vector<ReachSlice*> reaches(slices_.begin(), slices_.end());
  LATTICED_RETURN_IF_ERROR(ShareReach(reaches));
  for (size_t s = 0; s < slices_.size(); ++s) {
    LATTICED_RETURN_IF_ERROR(slices_[s]->ShareEdges(shared_->slices[s].edges));
  }
  return absl::OkStatus();
}

absl::Status ToleranceExchange::Evaluate(std::span<const Vec3d> control_points,
                                         const QuantisationBox& box,
                                         std::span<const std::span<const uint32_t>> chunks) {
  for (size_t s = 0; s < slices_.size(); ++s) {
    LATTICED_RETURN_IF_ERROR(slices_[s]->Bound(control_points, box, chunks[s]));
  }
  LATTICED_RETURN_IF_ERROR(GatherBounds());
  ToleranceSteps steps(spec_.tolerance, box, GridBits(spec_));
  LATTICED_ASSIGN_OR_RETURN(uint64_t points, Choose(steps.curvature()));
  while (points > most_points_) {
    steps.Double();
    LATTICED_ASSIGN_OR_RETURN(points, Choose(steps.curvature()));
  }
  for (ToleranceSlice* const slice : slices_) LATTICED_RETURN_IF_ERROR(slice->Finish());
  return absl::OkStatus();
}

absl::Status ToleranceExchange::GatherBounds() {
  std::ranges::fill(largest_, 0.0f);
  for (size_t s = 0; s < slices_.size(); ++s) {
    LATTICED_ASSIGN_OR_RETURN(const std::span<const float> bounds, slices_[s]->SharedBounds());
    for (size_t i = 0; i < bounds.size(); ++i) {
      float& largest = largest_[shared_->slices[s].numbers[i]];
      largest = LargerBound(largest, bounds[i]);
    }
  }
  for (size_t s = 0; s < slices_.size(); ++s) {
    std::ranges::transform(shared_->slices[s].numbers, raised_[s].begin(),
                           [this](uint32_t number) { return largest_[number]; });
  }
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> ToleranceExchange::Choose(double curvature_tolerance) {
  for (size_t s = 0; s < slices_.size(); ++s) {
    LATTICED_RETURN_IF_ERROR(slices_[s]->Choose(curvature_tolerance, raised_[s]));
  }
  uint64_t points = 0;
  for (ToleranceSlice* const slice : slices_) {
    LATTICED_ASSIGN_OR_RETURN(const uint64_t some, slice->CountPoints());
    points += some;
  }
  return points;
}

size_t ToleranceExchange::BytesFor(const SharedEdges& shared) {
  size_t entries = shared.edges.size();
  for (const SharedEdges::Slice& slice : shared.slices) entries += slice.edges.size();
  return entries * sizeof(float);
}

size_t ToleranceExchange::MostBytes(const SharedEdges& shared) {
  // Bounds in both directions, in pinned blocks that are powers of two and at least a page.
  constexpr size_t kPinnedBytes = 4 * sizeof(float), kPageBytes = 4096;
  size_t bytes = BytesFor(shared);
  for (const SharedEdges::Slice& slice : shared.slices) {
    bytes += kPageBytes + slice.edges.size() * kPinnedBytes;
  }
  return bytes;
}

}  // namespace latticed
