// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/cpu/cpu_view.h"

#include <algorithm>
#include <utility>

#include "core/view/view_layout.h"

namespace latticed {

CpuView::CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                 std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
                 HostBuffer vertices)
    : CheckedView(std::move(plan), spec),
      layout_(MakeVertexLayout(this->plan(), spec)),
      context_(std::move(context)),
      encoder_(this->plan(), spec, context_->encoder, context_->arena),
      kernel_(std::move(kernel)),
      vertices_(std::move(vertices)) {}

absl::Status CpuView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  std::ranges::copy(ChunkBytes(chunk), out.begin());
  return absl::OkStatus();
}

std::span<const uint8_t> CpuView::ChunkBytes(uint32_t chunk) const {
  return vertices_.span().subspan(layout_.ChunkOffset(chunk), layout_.ChunkBytes(chunk));
}

absl::Status CpuView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                   std::span<VertexDigest> digests, std::span<SharedBytes> results,
                                   TakeEarly /*early*/) {
  const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return ChunkBytes(chunks[i]); };
  return encoder_.Encode(chunks, encoding, box().range, bytes_of, digests, results);
}

MemoryUse CpuView::memory() const {
  MemoryUse use = kernel_->memory();
  use["vertices"] += vertices_.size();
  use["staging"] += encoder_.MemoryBytes();
  return use;
}

}  // namespace latticed
