// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned_view.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "core/view/rising.h"

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
  if (auto s = contract_.CheckEvaluate(control_points, box, chunks); !s.ok()) return s;
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
    if (auto s = parts_[p].view->Evaluate(control_points, box, named); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status SpannedView::Read(uint32_t chunk, std::span<uint8_t> out) {
  if (auto status = contract_.CheckRead(chunk, out.size()); !status.ok()) return status;
  const Part& part = parts_[PartOf(chunk)];
  return part.view->Read(chunk - part.first_chunk, out);
}

absl::StatusOr<std::vector<SharedBytes>> SpannedView::Encode(std::span<const uint32_t> chunks,
                                                             Encoding encoding,
                                                             std::span<VertexDigest> digests) {
  if (auto status = contract_.CheckEncode(chunks, encoding); !status.ok()) return status;
  try {
    std::vector<std::vector<uint32_t>> named(parts_.size());
    std::vector<std::vector<size_t>> places(parts_.size());
    for (size_t i = 0; i < chunks.size(); ++i) {
      const size_t p = PartOf(chunks[i]);
      named[p].push_back(chunks[i] - parts_[p].first_chunk);
      places[p].push_back(i);
    }
    std::vector<SharedBytes> results(chunks.size());
    for (size_t p = 0; p < parts_.size(); ++p) {
      if (named[p].empty()) continue;
      std::vector<VertexDigest> known(digests.empty() ? 0 : named[p].size());
      for (size_t i = 0; i < known.size(); ++i) known[i] = digests[places[p][i]];
      auto encoded = parts_[p].view->Encode(named[p], encoding, known);
      if (!encoded.ok()) return encoded;
      for (size_t i = 0; i < places[p].size(); ++i) results[places[p][i]] = (*encoded)[i];
      for (size_t i = 0; i < known.size(); ++i) digests[places[p][i]] = known[i];
    }
    return results;
  } catch (const std::bad_alloc&) {
    return error::AllocationFailed("the encoding");
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
