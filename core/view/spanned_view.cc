// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned_view.h"

#include <algorithm>
#include <new>
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
    : plan_(std::move(plan)), contract_(*plan_, spec), parts_(std::move(parts)) {
  uint32_t most = 0;
  for (size_t p = 0; p < parts_.size(); ++p) most = std::max(most, End(p) - parts_[p].first_chunk);
  all_ = NumbersBelow(most);
}

uint32_t SpannedView::End(size_t part) const {
  return part + 1 < parts_.size() ? parts_[part + 1].first_chunk
                                  : static_cast<uint32_t>(plan_->chunk_count());
}

size_t SpannedView::PartOf(uint32_t chunk) const {
  const auto after = std::ranges::upper_bound(parts_, chunk, {}, &Part::first_chunk);
  return static_cast<size_t>(after - parts_.begin()) - 1;
}

absl::Status SpannedView::Evaluate(std::span<const Vec3d> control_points,
                                   const QuantisationBox& box, std::span<const uint32_t> chunks) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEvaluate(control_points, box, chunks));
  absl::Status status;
  try {
    status = EvaluateParts(control_points, box, chunks);
  } catch (const std::bad_alloc&) {
    status = error::AllocationFailed("the evaluation");
  }
  if (!status.ok()) {
    contract_.Lost();
    return status;
  }
  contract_.Evaluated(box);
  return absl::OkStatus();
}

absl::Status SpannedView::EvaluateParts(std::span<const Vec3d> control_points,
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

absl::Status SpannedView::Read(uint32_t chunk, std::span<uint8_t> out) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckRead(chunk, out.size()));
  const Part& part = parts_[PartOf(chunk)];
  return part.view->Read(chunk - part.first_chunk, out);
}

std::vector<SpannedView::Share> SpannedView::ShareOut(std::span<const uint32_t> chunks,
                                                      std::span<const VertexDigest> digests) const {
  std::vector<Share> shares(parts_.size());
  for (size_t i = 0; i < chunks.size();) {
    const size_t p = PartOf(chunks[i]), place = i;
    const uint32_t first = parts_[p].first_chunk, end = End(p);
    Share& share = shares[p];
    for (; i < chunks.size() && chunks[i] >= first && chunks[i] < end; ++i) {
      share.chunks.push_back(chunks[i] - first);
    }
    share.runs.push_back({place, i - place});
    if (digests.empty()) continue;
    const auto its = digests.subspan(place, i - place);
    share.digests.insert(share.digests.end(), its.begin(), its.end());
  }
  return shares;
}

// The first share on the caller's thread.
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

void SpannedView::Gather(Share& share, std::span<SharedBytes> results,
                         std::span<VertexDigest> digests) {
  size_t done = 0;
  for (const auto& [place, count] : share.runs) {
    std::ranges::move(std::span(*share.results).subspan(done, count),
                      results.subspan(place).begin());
    if (!digests.empty()) {
      std::ranges::copy(std::span(share.digests).subspan(done, count),
                        digests.subspan(place).begin());
    }
    done += count;
  }
}

absl::StatusOr<std::vector<SharedBytes>> SpannedView::Encode(std::span<const uint32_t> chunks,
                                                             Encoding encoding,
                                                             std::span<VertexDigest> digests) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEncode(chunks, encoding));
  if (chunks.empty()) return std::vector<SharedBytes>();
  try {
    std::vector<SharedBytes> results(chunks.size());
    std::vector<Share> shares = ShareOut(chunks, digests);
    EncodeAtOnce(shares, encoding);
    for (Share& share : shares) {
      if (share.chunks.empty()) continue;
      if (!share.results.ok()) return share.results.status();
      Gather(share, results, digests);
    }
    return results;
  } catch (const std::bad_alloc&) {
    return error::AllocationFailed("the encoding");
  } catch (const std::system_error&) {
    return error::AllocationFailed("a thread of the encoding");
  }
}

MemoryUse SpannedView::memory() const {
  MemoryUse use;
  for (const Part& part : parts_) {
    for (const auto& [purpose, bytes] : part.view->memory()) use[purpose] += bytes;
  }
  return use;
}

}  // namespace latticed
