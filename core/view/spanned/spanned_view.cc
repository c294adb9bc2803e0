// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/spanned_view.h"

#include <algorithm>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/view/sorted_numbers.h"
#include "core/view/spanned/run_at_once.h"

namespace latticed {

SpannedView::SpannedView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                         std::vector<Part> parts, std::unique_ptr<ToleranceExchange> exchange)
    : CheckedView(std::move(plan), spec),
      parts_(std::move(parts)),
      named_(parts_.size()),
      exchange_(std::move(exchange)) {
  uint32_t most = 0;
  for (size_t p = 0; p < parts_.size(); ++p) most = std::max(most, End(p) - parts_[p].first_chunk);
  all_ = NumbersBelow(most);
}

uint32_t SpannedView::End(size_t part) const {
  return part + 1 < parts_.size() ? parts_[part + 1].first_chunk
                                  : static_cast<uint32_t>(plan().chunk_count());
}

size_t SpannedView::PartOf(uint32_t chunk) const {
  const auto after = std::ranges::upper_bound(parts_, chunk, {}, &Part::first_chunk);
  return static_cast<size_t>(after - parts_.begin()) - 1;
}

std::span<const uint32_t> SpannedView::ChunksOf(size_t part, std::span<const uint32_t> chunks) {
  const uint32_t first = parts_[part].first_chunk, end = End(part);
  const auto from = std::ranges::lower_bound(chunks, first);
  const auto to = std::lower_bound(from, chunks.end(), end);
  const auto count = static_cast<size_t>(to - from);
  if (count == end - first) return all_.first(count);
  named_[part].assign(from, to);
  for (uint32_t& chunk : named_[part]) chunk -= first;
  return named_[part];
}

absl::Status SpannedView::EvaluateChunks(std::span<const Vec3d> control_points,
                                         const QuantisationBox& box,
                                         std::span<const uint32_t> chunks) {
  if (exchange_ != nullptr) return EvaluateWithTolerance(control_points, box, chunks);
  for (size_t p = 0; p < parts_.size(); ++p) {
    const std::span<const uint32_t> named = ChunksOf(p, chunks);
    if (named.empty()) continue;
    LATTICED_RETURN_IF_ERROR(parts_[p].view->Evaluate(control_points, box, named));
  }
  return absl::OkStatus();
}

absl::Status SpannedView::EvaluateWithTolerance(std::span<const Vec3d> control_points,
                                                const QuantisationBox& box,
                                                std::span<const uint32_t> chunks) {
  std::vector<std::span<const uint32_t>> named;
  for (size_t p = 0; p < parts_.size(); ++p) named.push_back(ChunksOf(p, chunks));
  LATTICED_RETURN_IF_ERROR(exchange_->Evaluate(control_points, box, named));
  also_changed_.clear();
  const auto codes = std::make_shared<std::vector<uint16_t>>();
  codes->reserve(plan().patches.size());
  for (const Part& part : parts_) {
    for (const uint32_t chunk : part.view->also_changed()) {
      also_changed_.push_back(part.first_chunk + chunk);
    }
    const PatternCodes own = part.view->Patterns();
    codes->insert(codes->end(), own.codes.begin(), own.codes.end());
  }
  patterns_ = {codes, *codes};
  return absl::OkStatus();
}

double SpannedView::certified_error() const {
  double largest = 0;
  for (const Part& part : parts_) largest = std::max(largest, part.view->certified_error());
  return largest;
}

absl::Status SpannedView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  const Part& part = parts_[PartOf(chunk)];
  return part.view->Read(chunk - part.first_chunk, out);
}

std::vector<SpannedView::Share> SpannedView::ShareOut(std::span<const uint32_t> chunks,
                                                      std::span<const VertexDigest> digests) const {
  std::vector<Share> shares(parts_.size());
  size_t p = 0;
  for (size_t i = 0; i < chunks.size(); ++i) {
    if (chunks[i] < parts_[p].first_chunk || chunks[i] >= End(p)) p = PartOf(chunks[i]);
    shares[p].places.push_back(i);
    shares[p].chunks.push_back(chunks[i] - parts_[p].first_chunk);
    if (!digests.empty()) shares[p].digests.push_back(digests[i]);
  }
  return shares;
}

absl::Status SpannedView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                       std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results, TakeEarly /*early*/) {
  std::vector<Share> shares = ShareOut(chunks, digests);
  std::vector<size_t> busy;
  for (size_t p = 0; p < shares.size(); ++p) {
    if (!shares[p].chunks.empty()) busy.push_back(p);
  }
  LATTICED_RETURN_IF_ERROR(RunAtOnce(busy, [&](size_t p) {
    Share& share = shares[p];
    share.results = CatchBadAlloc("the encoding", [&] {
      return parts_[p].view->Encode(share.chunks, encoding, share.digests);
    });
  }));
  for (Share& share : shares) {
    if (share.chunks.empty()) continue;
    LATTICED_RETURN_IF_ERROR(share.results.status());
    for (size_t k = 0; k < share.places.size(); ++k) {
      results[share.places[k]] = std::move((*share.results)[k]);
      if (!digests.empty()) digests[share.places[k]] = share.digests[k];
    }
  }
  return absl::OkStatus();
}

MemoryUse SpannedView::memory() const {
  MemoryUse use;
  for (const Part& part : parts_) {
    for (const auto& [purpose, bytes] : part.view->memory()) use[purpose] += bytes;
  }
  if (exchange_ != nullptr) {
    use["levels"] += exchange_->MemoryBytes() + patterns_.codes.size_bytes();
  }
  return use;
}

}  // namespace latticed
