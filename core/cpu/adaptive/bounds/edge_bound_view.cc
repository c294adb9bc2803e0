// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/bounds/edge_bound_view.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/view/bounds/encode_bounds.h"

namespace latticed {

EdgeBoundView::EdgeBoundView(std::shared_ptr<const fused::FusedPlan> plan, const ViewSpec& spec,
                             std::shared_ptr<CpuContext> context)
    : CheckedView(plan->plan, spec),
      fused_plan_(std::move(plan)),
      context_(std::move(context)),
      bounder_(fused_plan_, context_->arena),
      bytes_(fused_plan_->plan) {}

absl::StatusOr<std::vector<Vec3d>> EdgeBoundView::BoxReach() {
  return std::vector<Vec3d>(bounder_.reach().begin(), bounder_.reach().end());
}

absl::Status EdgeBoundView::SetReach(std::span<const Vec3d> reach) {
  std::ranges::copy(reach, bounder_.reach().begin());
  return absl::OkStatus();
}

absl::Status EdgeBoundView::EvaluateChunks(std::span<const Vec3d> control_points,
                                           const QuantisationBox&,
                                           std::span<const uint32_t> chunks) {
  fused::FrameBoxes boxes(*fused_plan_, control_points);
  bounder_.Bound(chunks, control_points, boxes,
                 [this](size_t patch, const CurvatureBounds<float>& bounds) {
                   bytes_.SetBounds(patch, bounds);
                 });
  const std::vector<uint32_t> changed = bytes_.Update(chunks, context_->arena);
  also_changed_.clear();
  std::ranges::set_difference(changed, chunks, std::back_inserter(also_changed_));
  return absl::OkStatus();
}

absl::Status EdgeBoundView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  std::ranges::copy(bytes_[chunk], out.begin());
  return absl::OkStatus();
}

absl::Status EdgeBoundView::EncodeChunks(std::span<const uint32_t> chunks, Encoding,
                                         std::span<VertexDigest> digests,
                                         std::span<SharedBytes> results, TakeEarly /*early*/) {
  EncodeBounds(
      chunks, [this](uint32_t chunk) { return bytes_[chunk]; }, digests, results);
  return absl::OkStatus();
}

MemoryUse EdgeBoundView::memory() const {
  return {{"bounds", bytes_.MemoryBytes() + bounder_.MemoryBytes()}};
}

uint64_t EdgeBoundView::MostBytes(const DeformPlan& plan) {
  return EdgeBoundTable::BytesFor(plan) + plan.boxes.size() * sizeof(Vec3d);
}

}  // namespace latticed
