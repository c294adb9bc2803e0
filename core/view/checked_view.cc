// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/checked_view.h"

#include <algorithm>

#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/view/sorted_numbers.h"
#include "fmt/format.h"

namespace latticed {
namespace {

absl::Status NotEvaluated() {
  return error::FailedPrecondition("NOT_EVALUATED", "evaluate the view first");
}

absl::Status CheckControlPoints(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  const auto expected = plan.control_point_count();
  if (control_points.size() == expected) return absl::OkStatus();
  return error::InvalidField(
      "lattice.control_points",
      fmt::format("got {} points, {} are needed", control_points.size(), expected));
}

}  // namespace

absl::Status CheckedView::CheckChunk(uint32_t chunk) const {
  if (chunk < plan_->chunk_count()) return absl::OkStatus();
  return error::OutOfRange("chunks", chunk, 0, static_cast<double>(plan_->chunk_count()) - 1);
}

absl::Status CheckedView::CheckEvaluate(std::span<const Vec3d> control_points,
                                        const QuantisationBox& box,
                                        std::span<const uint32_t> chunks) const {
  LATTICED_RETURN_IF_ERROR(CheckControlPoints(*plan_, control_points));
  if (!chunks.empty()) {
    LATTICED_RETURN_IF_ERROR(CheckChunk(chunks.back()));
  }
  if (!IsStrictlySorted(chunks)) {
    return error::InvalidField("chunks", "must rise, each chunk once");
  }
  const bool same_box = box_ && box_->origin == box.origin && box_->range == box.range;
  // A tolerance is measured by the box.
  const bool boxed = spec_.format == VertexFormat::kQuantised ||
                     (spec_.format == VertexFormat::kFloat32 && spec_.tolerance > 0);
  if ((!box_ || (boxed && !same_box)) && chunks.size() != plan_->chunk_count()) {
    return error::InvalidField("chunks",
                               "the first evaluation, and one under another box, needs all");
  }
  return absl::OkStatus();
}

absl::Status CheckedView::Evaluate(std::span<const Vec3d> control_points,
                                   const QuantisationBox& box, std::span<const uint32_t> chunks) {
  LATTICED_RETURN_IF_ERROR(CheckEvaluate(control_points, box, chunks));
  const absl::Status status =
      CatchBadAlloc("the evaluation", [&] { return EvaluateChunks(control_points, box, chunks); });
  box_ = status.ok() ? std::optional(box) : std::nullopt;
  return status;
}

absl::Status CheckedView::Read(uint32_t chunk, std::span<uint8_t> out) {
  LATTICED_RETURN_IF_ERROR(CheckChunk(chunk));
  if (!box_) return NotEvaluated();
  const size_t needed = SizeOf(chunk);
  if (out.size() == needed) return ReadChunk(chunk, out);
  return error::InvalidField(
      "out", fmt::format("got room for {} bytes, chunk {} has {}", out.size(), chunk, needed));
}

absl::StatusOr<std::vector<SharedBytes>> CheckedView::Encode(std::span<const uint32_t> chunks,
                                                             Encoding encoding,
                                                             std::span<VertexDigest> digests,
                                                             TakeEarly early) {
  if (!box_) return NotEvaluated();
  if (FormatOf(encoding) != spec_.format) {
    return error::InvalidField("encoding", "its vertex format must be the view's");
  }
  // A device may wait for this.
  const auto outside = std::ranges::find_if(
      chunks, [count = plan_->chunk_count()](uint32_t chunk) { return chunk >= count; });
  if (outside != chunks.end()) return CheckChunk(*outside);
  return CatchBadAlloc("the encoding", [&]() -> absl::StatusOr<std::vector<SharedBytes>> {
    std::vector<SharedBytes> results(chunks.size());
    if (chunks.empty()) return results;
    LATTICED_RETURN_IF_ERROR(EncodeChunks(chunks, encoding, digests, results, early));
    return results;
  });
}

absl::Status CheckControlNets(const DeformPlan& plan, std::span<const Vec3d> control_points,
                              size_t first, size_t last) {
  if (first > last || last > plan.patches.size()) {
    return error::InvalidField(
        "patches", fmt::format("got [{}, {}), the plan has {}", first, last, plan.patches.size()));
  }
  return CheckControlPoints(plan, control_points);
}

}  // namespace latticed
