// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_view.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/view/view_layout.h"

namespace latticed {
absl::StatusOr<std::unique_ptr<CpuView>> CpuView::Create(std::shared_ptr<const DeformPlan> plan,
                                                         const ViewSpec& spec,
                                                         std::unique_ptr<VertexKernel> kernel,
                                                         std::shared_ptr<CpuContext> context) {
  LATTICED_ASSIGN_OR_RETURN(
      auto vertices, HostBuffer::Create("vertices", MakeVertexLayout(*plan, spec).total_bytes()));
  return std::unique_ptr<CpuView>(new CpuView(std::move(plan), spec, std::move(kernel),
                                              std::move(context), std::move(vertices)));
}

CpuView::CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                 std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
                 HostBuffer vertices)
    : plan_(std::move(plan)),
      layout_(MakeVertexLayout(*plan_, spec)),
      contract_(*plan_, spec),
      context_(std::move(context)),
      encoder_(*plan_, spec, context_->encoder, context_->arena),
      kernel_(std::move(kernel)),
      vertices_(std::move(vertices)) {}

absl::Status CpuView::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                               std::span<const uint32_t> chunks) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEvaluate(control_points, box, chunks));
  try {
    if (auto status = kernel_->Evaluate(control_points, box, chunks, vertices_.span());
        !status.ok()) {
      contract_.Lost();
      return status;
    }
  } catch (const std::bad_alloc&) {
    contract_.Lost();
    return error::AllocationFailed("the evaluation");
  }
  contract_.Evaluated(box);
  return absl::OkStatus();
}

absl::Status CpuView::Read(uint32_t chunk, std::span<uint8_t> out) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckRead(chunk, out.size()));
  std::ranges::copy(ChunkBytes(chunk), out.begin());
  return absl::OkStatus();
}

std::span<const uint8_t> CpuView::ChunkBytes(uint32_t chunk) const {
  return vertices_.span().subspan(layout_.ChunkOffset(chunk), layout_.ChunkBytes(chunk));
}

absl::StatusOr<std::vector<SharedBytes>> CpuView::Encode(std::span<const uint32_t> chunks,
                                                         Encoding encoding,
                                                         std::span<VertexDigest> digests) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEncode(chunks, encoding));
  const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return ChunkBytes(chunks[i]); };
  try {
    std::vector<SharedBytes> results(chunks.size());
    LATTICED_RETURN_IF_ERROR(
        encoder_.Encode(chunks, encoding, contract_.box().range, bytes_of, digests, results));
    return results;
  } catch (const std::bad_alloc&) {
    return error::AllocationFailed("the encoding");
  }
}

MemoryUse CpuView::memory() const {
  MemoryUse use = kernel_->memory();
  use["vertices"] += vertices_.size();
  use["staging"] += encoder_.MemoryBytes();
  return use;
}

}  // namespace latticed
