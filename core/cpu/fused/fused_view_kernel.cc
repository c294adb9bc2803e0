// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/fused_view_kernel.h"

#include <utility>

namespace latticed {

FusedViewKernel::FusedViewKernel(std::shared_ptr<const FusedKernel> kernel, const ViewSpec& spec,
                                 std::shared_ptr<CpuContext> context)
    : kernel_(std::move(kernel)), spec_(spec), context_(std::move(context)) {
  // Integers have one order only: their stores are small already.
  if (spec_.format != VertexFormat::kFloat32) spec_.lane_order = false;
}

absl::Status FusedViewKernel::Evaluate(std::span<const Vec3d> control_points,
                                       const QuantisationBox& box, std::span<const uint32_t> chunks,
                                       std::span<uint8_t> vertices, DeformView::Between between) {
  return kernel_->Evaluate(control_points, box, chunks, spec_, vertices, context_->arena, between);
}

size_t FusedViewKernel::OwnOrderBytes() const {
  return spec_.lane_order ? kernel_->LaneOrderBytes(spec_) : 0;
}

void FusedViewKernel::ReadChunk(std::span<const uint8_t> vertices, uint32_t chunk,
                                std::span<uint8_t> out) const {
  kernel_->ReadLaneOrder(vertices, spec_, chunk, out);
}

}  // namespace latticed
