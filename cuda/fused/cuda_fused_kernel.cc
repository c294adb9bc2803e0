// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/cuda_fused_kernel.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/view/view_layout.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

using kernels::LaneFormat;
using kernels::WireChunk;

size_t WireListBytes(const DeformPlan& plan) { return plan.chunk_count() * sizeof(WireChunk); }

LaneFormat FormatFor(const ViewSpec& spec) {
  if (spec.format == VertexFormat::kFloat32) return LaneFormat::kFloat32;
  const bool wide = spec.normals != NormalMode::kNone && spec.normal_bits > 8;
  return wide ? LaneFormat::kQuantised16 : LaneFormat::kQuantised8;
}

// Points of all chunks, with the padding of the last one.
size_t PaddedPoints(const DeformPlan& plan, const ViewSpec& spec) {
  return plan.chunk_count() * limits::kPatchesPerChunk *
         static_cast<size_t>(PointsPerPatch(spec.segments));
}

}  // namespace

uint64_t CudaFusedKernel::DeviceBytesFor(const DeformPlan& plan) {
  return StagedUpload::DeviceBytesFor(WireListBytes(plan)) + PolynomialMemory::BytesFor(plan);
}

absl::StatusOr<std::unique_ptr<CudaFusedKernel>> CudaFusedKernel::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
    const ViewSpec& spec, CudaContext& context, std::shared_ptr<CudaLane> lane,
    DeviceReservation& from) {
  LATTICED_ASSIGN_OR_RETURN(const auto tables,
                            device_plan->Tables(spec.normals == NormalMode::kSmooth, from));
  LATTICED_ASSIGN_OR_RETURN(auto wire_chunks,
                            StagedUpload::Create(context, lane, WireListBytes(*plan), from));
  LATTICED_ASSIGN_OR_RETURN(auto polynomials,
                            PolynomialMemory::Create(*plan, from, lane->stream().get()));
  std::unique_ptr<CudaFusedKernel> kernel(
      new CudaFusedKernel(std::move(plan), std::move(device_plan), spec, std::move(lane), tables,
                          {std::move(wire_chunks), std::move(polynomials)}));
  LATTICED_RETURN_IF_ERROR(kernel->CountBlocksAtOnce(context.device()));
  return kernel;
}

CudaFusedKernel::CudaFusedKernel(std::shared_ptr<const DeformPlan> plan,
                                 std::shared_ptr<DevicePlan> device_plan, const ViewSpec& spec,
                                 std::shared_ptr<CudaLane> lane, kernels::PlanTables tables,
                                 Buffers buffers)
    : plan_(std::move(plan)),
      device_plan_(std::move(device_plan)),
      spec_(spec),
      lane_(std::move(lane)),
      tables_(tables),
      buffers_(std::move(buffers)) {}

absl::Status CudaFusedKernel::CountBlocksAtOnce(int device) {
  LATTICED_ASSIGN_OR_RETURN(const auto multiprocessors, CountMultiprocessors(device));
  const kernels::FusedLaunch any{.plan = tables_,
                                 .tables = device_plan_->fused_tables(),
                                 .segments = spec_.segments,
                                 .normals = NormalsOf(spec_.normals),
                                 .output = {.format = FormatFor(spec_)}};
  int blocks = 0;
  const auto error = kernels::FusedCall(any).CountBlocksAtOnce(blocks);
  // Some devices have 99 KB of shared memory where others have 163 or 227.
  if (error == cudaErrorInvalidValue) {
    static_cast<void>(cudaGetLastError());
    return error::InvalidField("view.segments", "this device has too little memory for so many",
                               "UNSUPPORTED");
  }
  blocks_at_once_ = std::max(multiprocessors * blocks, 1);
  return CudaStatus(error, "the blocks of a multiprocessor");
}

size_t CudaFusedKernel::LaneOrderBytes(const DeformPlan& plan, const ViewSpec& spec) {
  switch (FormatFor(spec)) {
    case LaneFormat::kFloat32:
      return PaddedPoints(plan, spec) * BytesPerPoint(spec);
    case LaneFormat::kQuantised8:
      return PaddedPoints(plan, spec) * 2 * sizeof(uint32_t);
    case LaneFormat::kQuantised16:
      return PaddedPoints(plan, spec) * 3 * sizeof(uint32_t);
  }
  return 0;
}

size_t CudaFusedKernel::FirstPlaneBytes() const {
  return PaddedPoints(*plan_, spec_) * 2 * sizeof(uint32_t);
}

kernels::BoxPolynomials CudaFusedKernel::Polynomials(const QuantisationBox& box) const {
  const bool floats = FormatFor(spec_) == LaneFormat::kFloat32;
  if (floats) return buffers_.polynomials.polynomials(1, {});
  return buffers_.polynomials.polynomials(1 / box.range,
                                          (plan_->local_origin - box.origin) / box.range);
}

kernels::FusedOutput CudaFusedKernel::Output(uint8_t* vertices) const {
  return {.format = FormatFor(spec_),
          .top = static_cast<float>((uint32_t{1} << spec_.position_bits) - 1),
          .normal_bits = spec_.normal_bits,
          .vertices = vertices,
          .second_plane = vertices + FirstPlaneBytes()};
}

absl::Status CudaFusedKernel::Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                                       std::span<const uint32_t> chunks,
                                       DeviceSpan<uint8_t> vertices) {
  if (chunks.empty()) return absl::OkStatus();
  kernels::FusedLaunch launch{.plan = tables_,
                              .tables = device_plan_->fused_tables(),
                              .polynomials = Polynomials(box),
                              .control_points = frame.control_points().data,
                              .attached = frame.attached().data,
                              .chunks = frame.chunks(),
                              .chunk_count = static_cast<uint32_t>(chunks.size()),
                              .blocks = {},
                              .patch_count = static_cast<uint32_t>(plan_->patches.size()),
                              .segments = spec_.segments,
                              .normals = NormalsOf(spec_.normals),
                              .output = Output(vertices.data)};
  const kernels::BoxList boxes{frame.boxes().data, static_cast<uint32_t>(frame.boxes().size)};
  const bool part = boxes.numbers != nullptr;
  launch.blocks = kernels::DivideChunks(launch, blocks_at_once_);
  std::array calls{frame.SendCall(),
                   kernels::BoxPolynomialsCall(tables_, launch.tables, launch.control_points, boxes,
                                               launch.polynomials),
                   kernels::FusedCall(launch)};
  return LaunchAll(calls, part);
}

absl::Status CudaFusedKernel::LaunchAll(std::span<kernels::KernelCall> calls, bool part) {
  if (lane_->marks_stages()) return LaunchByStages(calls);
  return (part ? part_graph_ : graph_).Launch(calls, lane_->stream().get());
}

absl::Status CudaFusedKernel::LaunchByStages(std::span<kernels::KernelCall> calls) {
  for (kernels::KernelCall& call : calls) {
    LATTICED_RETURN_IF_ERROR(CudaStatus(call.Launch(lane_->stream().get()), "an evaluation"));
    if (&call == &calls.front()) lane_->Enqueued("copy");
  }
  return absl::OkStatus();
}

absl::StatusOr<const WireChunk*> CudaFusedKernel::SendWireChunks(std::span<const uint32_t> chunks) {
  const VertexLayout layout = MakeVertexLayout(*plan_, spec_);
  LATTICED_ASSIGN_OR_RETURN(const auto to, buffers_.wire_chunks.Begin());
  uint64_t offset = 0;
  for (size_t i = 0; i < chunks.size(); ++i) {
    const WireChunk chunk{offset, chunks[i]};
    std::memcpy(to + i * sizeof(chunk), &chunk, sizeof(chunk));
    offset += layout.ChunkBytes(chunks[i]);
  }
  absl::Status sent = buffers_.wire_chunks.Send(chunks.size() * sizeof(WireChunk));
  sent.Update(buffers_.wire_chunks.Sent());
  if (!sent.ok()) return sent;
  return reinterpret_cast<const WireChunk*>(buffers_.wire_chunks.device_data());
}

absl::Status CudaFusedKernel::ToWireOrder(DeviceSpan<const uint8_t> vertices,
                                          std::span<const uint32_t> chunks,
                                          DeviceSpan<uint8_t> out) {
  if (chunks.empty()) return absl::OkStatus();
  const WireChunk* list = nullptr;
  if (std::ranges::adjacent_find(chunks, [](uint32_t a, uint32_t b) { return b != a + 1; }) !=
      chunks.end()) {
    LATTICED_ASSIGN_OR_RETURN(list, SendWireChunks(chunks));
  }
  const kernels::WireOrder order{.format = FormatFor(spec_),
                                 .vertices = vertices.data,
                                 .second_plane = vertices.data + FirstPlaneBytes(),
                                 .chunks = list,
                                 .first_chunk = chunks.front(),
                                 .chunk_bytes = MakeVertexLayout(*plan_, spec_).ChunkBytes(0),
                                 .chunk_count = static_cast<uint32_t>(chunks.size()),
                                 .patch_count = static_cast<uint32_t>(plan_->patches.size()),
                                 .points_per_patch = PointsPerPatch(spec_.segments),
                                 .normals = spec_.normals != NormalMode::kNone,
                                 .out = out.data};
  return CudaStatus(kernels::LaunchWireOrder(order, lane_->stream().get()), "the wire order");
}

MemoryUse CudaFusedKernel::memory() const {
  return {{"device_box_polynomials", buffers_.polynomials.size_bytes()},
          {"device_staging", buffers_.wire_chunks.DeviceBytes()},
          {"staging", buffers_.wire_chunks.PinnedBytes()}};
}

}  // namespace latticed
