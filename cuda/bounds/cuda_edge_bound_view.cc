// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/bounds/cuda_edge_bound_view.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.h"
#include "core/patches/edge_bound.h"
#include "core/patches/edge_order.h"
#include "core/view/bounds/encode_bounds.h"
#include "cuda/adaptive/adaptive_memory.h"
#include "cuda/adaptive/box_reach.h"
#include "cuda/bounds/bound_kernels.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

using kernels::kEdgeByteChunks;

// In pinned memory: where the words of changed chunks begin, behind the bytes of all edges, and where they end.
size_t ChangedAt(const DeformPlan& plan) {
  return (plan.edges.size() + sizeof(uint32_t) - 1) / sizeof(uint32_t) * sizeof(uint32_t);
}
size_t PinnedBytes(const DeformPlan& plan) {
  return ChangedAt(plan) +
         (plan.chunk_count() + kEdgeByteChunks - 1) / kEdgeByteChunks * sizeof(uint32_t);
}

}  // namespace

uint64_t CudaEdgeBoundView::DeviceBytesFor(const DeformPlan& plan) {
  return EdgeBoundMemory::BytesFor(plan) + CudaFrame::DeviceBytesFor(plan, false) +
         PolynomialMemory::BytesFor(plan);
}

uint64_t CudaEdgeBoundView::HostBytesFor(const DeformPlan& plan) {
  return PinnedMemory::BlockBytes(PinnedBytes(plan)) + CudaFrame::PinnedBytesFor(plan, false) +
         (2 * plan.chunk_count() + 1) * sizeof(uint32_t);
}

absl::StatusOr<std::unique_ptr<CudaEdgeBoundView>> CudaEdgeBoundView::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
    const ViewSpec& spec, std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
    DeviceReservation& from) {
  const cudaStream_t stream = lane->stream().get();
  LATTICED_ASSIGN_OR_RETURN(const auto tables, device_plan->Tables(/*smooth=*/false, from));
  LATTICED_ASSIGN_OR_RETURN(auto frame, CudaFrame::Create(plan, nullptr, *context, lane, from));
  LATTICED_ASSIGN_OR_RETURN(auto polynomials, PolynomialMemory::Create(*plan, from, stream));
  std::vector<uint32_t> first_edges = FirstEdges(*plan);
  LATTICED_ASSIGN_OR_RETURN(auto memory, EdgeBoundMemory::Create(*plan, first_edges, from, stream));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context->pinned().Borrow(PinnedBytes(*plan)));
  std::ranges::fill_n(pinned.data(), static_cast<ptrdiff_t>(plan->edges.size()), uint8_t{0});
  const bool is_empty = plan->patches.empty();
  std::unique_ptr<CudaEdgeBoundView> view(new CudaEdgeBoundView(
      std::move(plan), std::move(device_plan), spec, std::move(context), std::move(lane), tables,
      std::move(first_edges),
      {std::move(frame), std::move(polynomials), std::move(memory), std::move(pinned)}));
  if (is_empty) return view;
  LATTICED_RETURN_IF_ERROR(view->LaunchStage(kernels::ReachCall(view->LaunchFor(0)), "reach"));
  return view;
}

CudaEdgeBoundView::CudaEdgeBoundView(std::shared_ptr<const DeformPlan> plan,
                                     std::shared_ptr<DevicePlan> device_plan, const ViewSpec& spec,
                                     std::shared_ptr<CudaContext> context,
                                     std::shared_ptr<CudaLane> lane,
                                     const kernels::PlanTables& tables,
                                     std::vector<uint32_t> first_edges, Parts parts)
    : CheckedView(std::move(plan), spec),
      context_(std::move(context)),
      device_plan_(std::move(device_plan)),
      lane_(std::move(lane)),
      tables_(tables),
      first_edges_(std::move(first_edges)),
      parts_(std::move(parts)) {}

CudaEdgeBoundView::~CudaEdgeBoundView() {
  // The destructor may free the target's tables, which kernels on the stream still read.
  const DeviceGuard guard(context_->device());
  static_cast<void>(lane_->stream().Synchronize("the view's end"));
}

kernels::AdaptiveLaunch CudaEdgeBoundView::LaunchFor(size_t chunks) const {
  kernels::AdaptiveLaunch launch{};
  launch.fused.plan = tables_;
  launch.fused.tables = device_plan_->fused_tables();
  launch.fused.polynomials = parts_.polynomials.polynomials(1, {});
  launch.fused.control_points = parts_.frame.control_points().data;
  launch.fused.attached = parts_.frame.attached().data;
  launch.fused.chunks = parts_.frame.chunks();
  launch.fused.chunk_count = static_cast<uint32_t>(chunks);
  launch.fused.patch_count = static_cast<uint32_t>(plan().patches.size());
  launch.tables = parts_.memory.tables();
  launch.state = parts_.memory.state();
  launch.plan_chunks = static_cast<uint32_t>(plan().chunk_count());
  return launch;
}

absl::Status CudaEdgeBoundView::LaunchStage(kernels::KernelCall call, std::string_view name) const {
  LATTICED_RETURN_IF_ERROR(CudaStatus(call.Launch(stream()), "an evaluation"));
  lane_->Enqueued(name);
  return absl::OkStatus();
}

absl::Status CudaEdgeBoundView::Launch(const kernels::AdaptiveLaunch& launch) {
  const kernels::FusedLaunch& fused = launch.fused;
  const kernels::EdgeBytesLaunch bytes{.edge_maxima = launch.state.edge_maxima,
                                       .first_edges = parts_.memory.first_edges(),
                                       .chunk_count = launch.plan_chunks,
                                       .unit = CurvatureUnit(plan().mesh_bounds),
                                       .bytes = parts_.memory.bytes(),
                                       .host_bytes = parts_.pinned.data(),
                                       .host_changed = const_cast<uint32_t*>(changed())};
  std::array calls{parts_.frame.SendCall(),
                   kernels::BoxPolynomialsCall(fused.plan, fused.tables, fused.control_points,
                                               {nullptr, 0}, fused.polynomials),
                   kernels::SlackCall(launch),
                   kernels::BoundsCall(launch),
                   kernels::EdgeMaximaCall(launch),
                   kernels::EdgeBytesCall(bytes)};
  constexpr std::array<std::string_view, calls.size()> kNames{"copy",   "polynomials", "slack",
                                                              "bounds", "maxima",      "bytes"};
  LATTICED_RETURN_IF_ERROR(parts_.memory.ClearMaxima());
  if (!lane_->marks_stages()) return graph_.Launch(calls, stream());
  for (size_t i = 0; i < calls.size(); ++i) {
    LATTICED_RETURN_IF_ERROR(LaunchStage(calls[i], kNames[i]));
  }
  return absl::OkStatus();
}

absl::Status CudaEdgeBoundView::EvaluateChunks(std::span<const Vec3d> control_points,
                                               const QuantisationBox&,
                                               std::span<const uint32_t> chunks) {
  also_changed_.clear();
  if (chunks.empty()) return absl::OkStatus();
  const DeviceGuard guard(context_->device());
  LATTICED_RETURN_IF_ERROR(parts_.frame.Stage(control_points, chunks));
  absl::Status status = Launch(LaunchFor(chunks.size()));
  status.Update(parts_.frame.Sent());
  // Also after an error: a kernel may still write to the host's memory.
  status.Update(lane_->stream().Synchronize("the bounds"));
  if (status.ok()) FindAlsoChanged(chunks);
  return status;
}

void CudaEdgeBoundView::FindAlsoChanged(std::span<const uint32_t> named) {
  size_t next = 0;
  for (uint32_t chunk = 0; chunk < plan().chunk_count(); ++chunk) {
    const bool is_named = next < named.size() && named[next] == chunk;
    if (is_named) ++next;
    const bool is_changed =
        (changed()[chunk / kEdgeByteChunks] >> chunk % kEdgeByteChunks & 1) != 0;
    if (is_changed && !is_named) also_changed_.push_back(chunk);
  }
}

const uint32_t* CudaEdgeBoundView::changed() const {
  return reinterpret_cast<const uint32_t*>(parts_.pinned.data() + ChangedAt(plan()));
}

std::span<const uint8_t> CudaEdgeBoundView::Bytes(uint32_t chunk) const {
  return {parts_.pinned.data() + first_edges_[chunk],
          first_edges_[chunk + 1] - first_edges_[chunk]};
}

absl::Status CudaEdgeBoundView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  std::ranges::copy(Bytes(chunk), out.begin());
  return absl::OkStatus();
}

absl::Status CudaEdgeBoundView::EncodeChunks(std::span<const uint32_t> chunks, Encoding,
                                             std::span<VertexDigest> digests,
                                             std::span<SharedBytes> results, TakeEarly /*early*/) {
  EncodeBounds(
      chunks, [this](uint32_t chunk) { return Bytes(chunk); }, digests, results);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Vec3d>> CudaEdgeBoundView::BoxReach() {
  const DeviceGuard guard(context_->device());
  return ReadReach(parts_.memory.state().reach, plan().boxes.size(), lane_->stream());
}

absl::Status CudaEdgeBoundView::SetReach(std::span<const Vec3d> reach) {
  const DeviceGuard guard(context_->device());
  return WriteReach(reach, parts_.memory.state().reach, lane_->stream());
}

MemoryUse CudaEdgeBoundView::memory() const {
  return {{"device_box_polynomials", parts_.polynomials.size_bytes()},
          {"device_bounds", parts_.memory.size_bytes()},
          {"device_staging", parts_.frame.DeviceBytes()},
          {"bounds", first_edges_.size() * sizeof(uint32_t)},
          {"staging", parts_.pinned.size() + parts_.frame.PinnedBytes()}};
}

}  // namespace latticed
