// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/spanned_bound_view.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/patches/edge_order.h"
#include "core/view/bounds/encode_bounds.h"
#include "core/view/spanned/reach_slice.h"
#include "core/view/spanned/run_at_once.h"

namespace latticed {

SpannedBoundView::SpannedBoundView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                                   std::shared_ptr<const SharedEdges> shared,
                                   std::vector<Slice> slices)
    : CheckedView(std::move(plan), spec),
      shared_(std::move(shared)),
      slices_(std::move(slices)),
      first_edges_(FirstEdges(this->plan())),
      bytes_(this->plan().edges.size()),
      largest_(shared_->edges.size()),
      scratch_(3 * limits::kPatchesPerChunk),
      is_changed_(this->plan().chunk_count()) {
  for (const SharedEdges::Slice& slice : shared_->slices)
    shared_bytes_.emplace_back(slice.edges.size());
}

absl::StatusOr<std::unique_ptr<SpannedBoundView>> SpannedBoundView::Create(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
    std::shared_ptr<const SharedEdges> shared, std::vector<Slice> slices) {
  std::vector<ReachSlice*> reaches;
  for (const Slice& slice : slices) {
    reaches.push_back(slice.view->reach_slice());
    if (reaches.back() != nullptr) continue;
    return error::InvalidField("view.encoding", "these devices cannot share it", "UNSUPPORTED");
  }
  LATTICED_RETURN_IF_ERROR(ShareReach(reaches));
  return std::unique_ptr<SpannedBoundView>(
      new SpannedBoundView(std::move(plan), spec, std::move(shared), std::move(slices)));
}

uint32_t SpannedBoundView::End(size_t slice) const {
  return slice + 1 < slices_.size() ? slices_[slice + 1].first_chunk
                                    : static_cast<uint32_t>(plan().chunk_count());
}

std::vector<std::vector<uint32_t>> SpannedBoundView::ShareOut(
    std::span<const uint32_t> chunks) const {
  std::vector<std::vector<uint32_t>> shares(slices_.size());
  size_t s = 0;
  for (const uint32_t chunk : chunks) {
    while (chunk >= End(s)) ++s;
    shares[s].push_back(chunk - slices_[s].first_chunk);
  }
  return shares;
}

absl::Status SpannedBoundView::EvaluateChunks(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks) {
  const std::vector<std::vector<uint32_t>> named = ShareOut(chunks);
  std::vector<size_t> busy;
  for (size_t s = 0; s < named.size(); ++s) {
    if (!named[s].empty()) busy.push_back(s);
  }
  std::vector<absl::Status> statuses(slices_.size());
  LATTICED_RETURN_IF_ERROR(RunAtOnce(busy, [&](size_t s) {
    statuses[s] = slices_[s].view->Evaluate(control_points, box, named[s]);
  }));
  for (const absl::Status& status : statuses) LATTICED_RETURN_IF_ERROR(status);
  for (const size_t s : busy) {
    for (const uint32_t chunk : named[s]) LATTICED_RETURN_IF_ERROR(TakeChunk(s, chunk));
    for (const uint32_t chunk : slices_[s].view->also_changed()) {
      LATTICED_RETURN_IF_ERROR(TakeChunk(s, chunk));
    }
  }
  RaiseShared();
  for (const uint32_t chunk : chunks) is_changed_[chunk] = 0;
  also_changed_.clear();
  for (uint32_t chunk = 0; chunk < is_changed_.size(); ++chunk) {
    if (std::exchange(is_changed_[chunk], uint8_t{0}) != 0) also_changed_.push_back(chunk);
  }
  return absl::OkStatus();
}

absl::Status SpannedBoundView::TakeChunk(size_t slice, uint32_t chunk) {
  const Slice& from = slices_[slice];
  const uint32_t first = from.first_edges[chunk], end = from.first_edges[chunk + 1];
  const std::span<uint8_t> bytes = std::span(scratch_).first(end - first);
  LATTICED_RETURN_IF_ERROR(from.view->Read(chunk, bytes));
  const SharedEdges::Slice& cut = shared_->slices[slice];
  auto next = static_cast<size_t>(std::ranges::lower_bound(cut.edges, first) - cut.edges.begin());
  uint32_t edge = first_edges_[from.first_chunk + chunk];  // of the plan
  for (uint32_t i = 0; i < bytes.size(); ++i) {
    if (next == cut.edges.size() || cut.edges[next] != first + i) {
      SetByte(edge++, bytes[i], from.first_chunk + chunk);
      continue;
    }
    shared_bytes_[slice][next] = bytes[i];
    if (shared_->edges[cut.numbers[next]] == edge) ++edge;  // first used here also in the plan
    ++next;
  }
  return absl::OkStatus();
}

void SpannedBoundView::RaiseShared() {
  std::ranges::fill(largest_, uint8_t{0});
  for (size_t s = 0; s < slices_.size(); ++s) {
    for (size_t i = 0; i < shared_bytes_[s].size(); ++i) {
      uint8_t& largest = largest_[shared_->slices[s].numbers[i]];
      largest = std::max(largest, shared_bytes_[s][i]);
    }
  }
  for (size_t n = 0; n < largest_.size(); ++n) {
    const uint32_t edge = shared_->edges[n];
    const auto after = std::ranges::upper_bound(first_edges_, edge);
    SetByte(edge, largest_[n], static_cast<uint32_t>(after - first_edges_.begin()) - 1);
  }
}

void SpannedBoundView::SetByte(uint32_t edge, uint8_t byte, uint32_t chunk) {
  if (std::exchange(bytes_[edge], byte) != byte) is_changed_[chunk] = 1;
}

std::span<const uint8_t> SpannedBoundView::Bytes(uint32_t chunk) const {
  return std::span(bytes_).subspan(first_edges_[chunk],
                                   first_edges_[chunk + 1] - first_edges_[chunk]);
}

absl::Status SpannedBoundView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  std::ranges::copy(Bytes(chunk), out.begin());
  return absl::OkStatus();
}

absl::Status SpannedBoundView::EncodeChunks(std::span<const uint32_t> chunks, Encoding,
                                            std::span<VertexDigest> digests,
                                            std::span<SharedBytes> results, TakeEarly /*early*/) {
  EncodeBounds(
      chunks, [this](uint32_t chunk) { return Bytes(chunk); }, digests, results);
  return absl::OkStatus();
}

uint64_t SpannedBoundView::MostBytes(const DeformPlan& plan, const SharedEdges& shared) {
  uint64_t on_cuts = shared.edges.size();
  for (const SharedEdges::Slice& slice : shared.slices) on_cuts += slice.edges.size();
  // First edges of plan and slices, and whether a chunk changed.
  return plan.edges.size() + on_cuts + plan.chunk_count() * (2 * sizeof(uint32_t) + 1) +
         (shared.slices.size() + 1) * sizeof(uint32_t);
}

MemoryUse SpannedBoundView::memory() const {
  MemoryUse use;
  for (const Slice& slice : slices_) {
    for (const auto& [purpose, bytes] : slice.view->memory()) use[purpose] += bytes;
  }
  use["bounds"] += MostBytes(plan(), *shared_);
  return use;
}

}  // namespace latticed
