// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned_view.h"

#include <algorithm>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/view/sorted_numbers.h"

namespace latticed {

SpannedView::SpannedView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                         std::vector<Part> parts)
    : CheckedView(std::move(plan), spec), parts_(std::move(parts)) {
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

absl::Status SpannedView::EvaluateChunks(std::span<const Vec3d> control_points,
                                         const QuantisationBox& box,
                                         std::span<const uint32_t> chunks) {
  auto next = chunks.begin();
  for (size_t p = 0; p < parts_.size(); ++p) {
    const uint32_t first = parts_[p].first_chunk;
    const auto end = std::lower_bound(next, chunks.end(), End(p));
    const auto count = static_cast<size_t>(end - next);
    std::span<const uint32_t> named = all_.first(count);
    if (count < End(p) - first) {
      named_.assign(next, end);
      for (uint32_t& chunk : named_) chunk -= first;
      named = named_;
    }
    next = end;
    if (named.empty()) continue;
    LATTICED_RETURN_IF_ERROR(parts_[p].view->Evaluate(control_points, box, named));
  }
  return absl::OkStatus();
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

// Encodes all shares concurrently, the first one on the caller's thread.
void SpannedView::EncodeAtOnce(std::vector<Share>& shares, Encoding encoding) const {
  const auto encode = [&](size_t p) {
    Share& share = shares[p];
    share.results = CatchBadAlloc("the encoding", [&] {
      return parts_[p].view->Encode(share.chunks, encoding, share.digests);
    });
  };
  const auto has_work = [](const Share& share) { return !share.chunks.empty(); };
  const auto first = std::ranges::find_if(shares, has_work) - shares.begin();
  std::vector<std::jthread> others;  // joined at the end
  for (size_t p = static_cast<size_t>(first) + 1; p < shares.size(); ++p) {
    if (has_work(shares[p])) others.emplace_back(encode, p);
  }
  encode(static_cast<size_t>(first));
}

absl::Status SpannedView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                       std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results) {
  std::vector<Share> shares = ShareOut(chunks, digests);
  try {
    EncodeAtOnce(shares, encoding);
  } catch (const std::system_error&) {
    return error::AllocationFailed("a thread of the encoding");
  }
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
  return use;
}

}  // namespace latticed
