// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/adaptive_view.h"

#include <algorithm>
#include <utility>

#include "core/view/view_layout.h"

namespace latticed {

AdaptiveView::AdaptiveView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                           std::unique_ptr<AdaptiveSurface> surface,
                           std::shared_ptr<CpuContext> context)
    : CheckedView(plan, spec),
      context_(std::move(context)),
      evaluator_(std::move(plan), spec, std::move(surface), context_->arena),
      vertices_(this->plan().chunk_count(), BytesPerPoint(spec)),
      encoder_(this->plan(), spec, context_->encoder, context_->arena,
               [this](uint32_t chunk) { return Patterns().OfChunk(chunk); }) {}

absl::Status AdaptiveView::EvaluateChunks(std::span<const Vec3d> control_points,
                                          const QuantisationBox& box,
                                          std::span<const uint32_t> chunks) {
  return evaluator_.Evaluate(control_points, box, chunks, vertices_);
}

absl::StatusOr<std::vector<Vec3d>> AdaptiveView::BoxReach() {
  return std::vector<Vec3d>(evaluator_.reach().begin(), evaluator_.reach().end());
}

absl::Status AdaptiveView::SetReach(std::span<const Vec3d> reach) {
  std::ranges::copy(reach, evaluator_.reach().begin());
  return absl::OkStatus();
}

absl::Status AdaptiveView::ShareEdges(std::span<const uint32_t> edges) {
  evaluator_.levels().Share(edges);
  return absl::OkStatus();
}

absl::Status AdaptiveView::Bound(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                 std::span<const uint32_t> chunks) {
  return evaluator_.Bound(control_points, box, chunks);
}

absl::StatusOr<std::span<const float>> AdaptiveView::SharedBounds() {
  return evaluator_.levels().SharedBounds();
}

absl::Status AdaptiveView::Choose(double curvature_tolerance,
                                  std::span<const float> shared_bounds) {
  evaluator_.levels().SetSharedBounds(shared_bounds);
  evaluator_.Choose(curvature_tolerance);
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> AdaptiveView::CountPoints() { return evaluator_.levels().point_count(); }

absl::Status AdaptiveView::Finish() {
  SetBox(evaluator_.box());
  return evaluator_.Finish(vertices_);
}

absl::Status AdaptiveView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  std::ranges::copy(vertices_[chunk], out.begin());
  return absl::OkStatus();
}

absl::Status AdaptiveView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                        std::span<VertexDigest> digests,
                                        std::span<SharedBytes> results, TakeEarly /*early*/) {
  const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return vertices_[chunks[i]]; };
  return encoder_.Encode(chunks, encoding, box().range, bytes_of, digests, results);
}

MemoryUse AdaptiveView::memory() const {
  return {{"vertices", vertices_.MemoryBytes()},
          {"levels", evaluator_.MemoryBytes()},
          {"staging", encoder_.MemoryBytes()}};
}

uint64_t AdaptiveView::MostBytes(const DeformPlan& plan, const ViewSpec& spec) {
  // A vector of bytes may have grown to twice its size.
  return 2 * MakeVertexLayout(plan, spec).total_bytes() + LevelTable::BytesFor(plan);
}

}  // namespace latticed
