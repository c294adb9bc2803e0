// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/cuda_adaptive_evaluator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/adaptive/edge_levels.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/view/view_layout.h"
#include "cuda/adaptive/box_reach.h"
#include "cuda/adaptive/surface/cuda_fused_surface.h"
#include "cuda/adaptive/surface/cuda_sampled_surface.h"
#include "cuda/device/cuda_status.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {
namespace {

// Of the tolerance. Rounding of an error in float32 takes less than what is left.
constexpr double kFloatShare = 1 - 1e-5;
constexpr size_t kMostBoundStages = 6;
// The room for vertices of a view that was never evaluated, in points of a patch.
constexpr uint64_t kFirstPoints = 4;

uint64_t MostPoints(const DeformPlan& plan, const ViewSpec& spec) {
  return plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments));
}

uint64_t FirstCapacity(const DeformPlan& plan, const ViewSpec& spec) {
  return std::min(plan.patches.size() * kFirstPoints, MostPoints(plan, spec));
}

size_t ResultBytes(const DeformPlan& plan) {
  constexpr size_t kPads = 3 * 256;
  return kPads + (plan.chunk_count() + 1) * sizeof(uint64_t) +
         plan.chunk_count() * limits::kPatchesPerChunk * sizeof(uint16_t);
}

absl::StatusOr<std::shared_ptr<const PinnedBuffer>> BorrowShared(CudaContext& context,
                                                                 size_t bytes) {
  LATTICED_ASSIGN_OR_RETURN(auto buffer, context.pinned().Borrow(bytes));
  return std::make_shared<const PinnedBuffer>(std::move(buffer));
}

kernels::LaneFormat WireFormat(const ViewSpec& spec) {
  if (spec.format == VertexFormat::kFloat32) return kernels::LaneFormat::kFloat32;
  const bool wide = spec.normals != NormalMode::kNone && spec.normal_bits > 8;
  return wide ? kernels::LaneFormat::kQuantised16 : kernels::LaneFormat::kQuantised8;
}

absl::StatusOr<std::unique_ptr<CudaAdaptiveSurface>> MakeSurface(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<const DevicePlan> device_plan,
    Pipeline pipeline, const ViewSpec& spec, CudaContext& context, DeviceReservation& from,
    cudaStream_t stream) {
  if (pipeline == Pipeline::kFused) {
    return CudaFusedSurface::Create(*plan, std::move(device_plan), spec, from, stream);
  }
  return CudaSampledSurface::Create(std::move(plan), std::move(device_plan), spec, context, from,
                                    stream);
}

}  // namespace

absl::StatusOr<uint64_t> CudaAdaptiveEvaluator::DeviceBytesFor(const DeformPlan& plan,
                                                               Pipeline pipeline,
                                                               const ViewSpec& spec) {
  LATTICED_ASSIGN_OR_RETURN(const uint64_t memory, AdaptiveMemory::BytesFor(plan));
  const uint64_t of_surface = pipeline == Pipeline::kFused ? CudaFusedSurface::BytesFor(plan)
                                                           : CudaSampledSurface::BytesFor(plan);
  return memory + CudaFrame::DeviceBytesFor(plan, false) + of_surface +
         FirstCapacity(plan, spec) * BytesPerPoint(spec);
}

uint64_t CudaAdaptiveEvaluator::HostBytesFor(const DeformPlan& plan) {
  return 2 * PinnedMemory::BlockBytes(ResultBytes(plan)) + CudaFrame::PinnedBytesFor(plan, false) +
         plan.chunk_count() * sizeof(uint32_t);
}

absl::StatusOr<std::unique_ptr<CudaAdaptiveEvaluator>> CudaAdaptiveEvaluator::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
    Pipeline pipeline, const ViewSpec& spec, std::shared_ptr<CudaContext> context,
    std::shared_ptr<CudaLane> lane, DeviceReservation& from) {
  const cudaStream_t stream = lane->stream().get();
  LATTICED_ASSIGN_OR_RETURN(const auto tables,
                            device_plan->Tables(spec.normals == NormalMode::kSmooth, from));
  LATTICED_ASSIGN_OR_RETURN(auto frame, CudaFrame::Create(plan, nullptr, *context, lane, from));
  LATTICED_ASSIGN_OR_RETURN(auto surface,
                            MakeSurface(plan, device_plan, pipeline, spec, *context, from, stream));
  LATTICED_ASSIGN_OR_RETURN(auto memory, AdaptiveMemory::Create(*plan, from, stream));
  const size_t vertex_bytes = FirstCapacity(*plan, spec) * BytesPerPoint(spec);
  LATTICED_ASSIGN_OR_RETURN(auto vertices,
                            DeviceBuffer<uint8_t>::Create(from, "vertices", vertex_bytes, stream));
  std::array<std::shared_ptr<const PinnedBuffer>, 2> results;
  for (auto& one : results) {
    LATTICED_ASSIGN_OR_RETURN(one, BorrowShared(*context, ResultBytes(*plan)));
  }
  LATTICED_ASSIGN_OR_RETURN(auto copies, CudaStream::Create(lane->priority()));
  LATTICED_ASSIGN_OR_RETURN(auto summed, CudaEvent::Create());
  LATTICED_ASSIGN_OR_RETURN(auto read_back, CudaEvent::Create());
  const bool is_empty = plan->patches.empty();
  std::unique_ptr<CudaAdaptiveEvaluator> evaluator(new CudaAdaptiveEvaluator(
      std::move(plan), std::move(device_plan), spec, std::move(context), std::move(lane), tables,
      {std::move(frame), std::move(surface), std::move(memory), std::move(vertices),
       std::move(results), std::move(copies), std::move(summed), std::move(read_back)}));
  if (is_empty) return evaluator;
  const kernels::KernelCall reach =
      evaluator->parts_.surface->ReachCall(evaluator->LaunchFor({}, {}));
  if (reach.kernel() != nullptr) LATTICED_RETURN_IF_ERROR(evaluator->Launch({reach, "reach"}));
  return evaluator;
}

CudaAdaptiveEvaluator::CudaAdaptiveEvaluator(std::shared_ptr<const DeformPlan> plan,
                                             std::shared_ptr<DevicePlan> device_plan,
                                             const ViewSpec& spec,
                                             std::shared_ptr<CudaContext> context,
                                             std::shared_ptr<CudaLane> lane,
                                             const kernels::PlanTables& tables, Parts parts)
    : plan_(std::move(plan)),
      device_plan_(std::move(device_plan)),
      spec_(spec),
      context_(std::move(context)),
      lane_(std::move(lane)),
      tables_(tables),
      most_points_(MostPoints(*plan_, spec)),
      parts_(std::move(parts)) {
  std::ranges::fill(std::span(incoming(), ResultBytes(*plan_)), uint8_t{0});
  KeepResults();
}

CudaAdaptiveEvaluator::~CudaAdaptiveEvaluator() {
  static_cast<void>(parts_.read_back.Synchronize());
}

absl::Status CudaAdaptiveEvaluator::Launch(AdaptiveStage stage) const {
  LATTICED_RETURN_IF_ERROR(CudaStatus(stage.call.Launch(stream()), "an evaluation"));
  lane_->Enqueued(stage.name);
  return absl::OkStatus();
}

kernels::AdaptiveLaunch CudaAdaptiveEvaluator::LaunchFor(const QuantisationBox& box,
                                                         std::span<const uint32_t> chunks) const {
  kernels::AdaptiveLaunch launch{
      .fused = {.plan = tables_,
                .tables = {},
                .polynomials = {},
                .control_points = parts_.frame.control_points().data,
                .attached = parts_.frame.attached().data,
                .chunks = parts_.frame.chunks(),
                .chunk_count = static_cast<uint32_t>(chunks.size()),
                .blocks = {},
                .patch_count = static_cast<uint32_t>(plan_->patches.size()),
                .segments = 0,
                .normals = NormalsOf(spec_.normals),
                .output = {.format = WireFormat(spec_),
                           .top = static_cast<float>((uint32_t{1} << spec_.position_bits) - 1),
                           .normal_bits = spec_.normal_bits,
                           .vertices = parts_.vertices.data(),
                           .second_plane = nullptr}},
      .tables = parts_.memory.tables(),
      .state = parts_.memory.state(),
      .plan_chunks = static_cast<uint32_t>(plan_->chunk_count()),
      .tolerance = 0,
      .most_points = capacity()};
  parts_.surface->Begin(box, launch);
  return launch;
}

absl::Status CudaAdaptiveEvaluator::Evaluate(std::span<const Vec3d> control_points,
                                             const QuantisationBox& box,
                                             std::span<const uint32_t> chunks) {
  also_changed_.clear();
  if (plan_->patches.empty()) certified_error_ = PointError(box, GridBits(spec_));
  if (chunks.empty()) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(Prepare(control_points, box, chunks));
  ToleranceSteps steps(spec_.tolerance, box, GridBits(spec_));
  SetTolerance(steps.curvature());
  LATTICED_RETURN_IF_ERROR(LaunchBounds(/*with_patterns=*/true));
  LATTICED_RETURN_IF_ERROR(LaunchPoints());
  LATTICED_ASSIGN_OR_RETURN(uint64_t points, CountPoints());
  // Ends: an infinite tolerance leaves three points a patch, which any number of segments gives.
  while (points > most_points_) {
    steps.Double();
    SetTolerance(steps.curvature());
    LATTICED_RETURN_IF_ERROR(LaunchPatterns());
    LATTICED_RETURN_IF_ERROR(LaunchPoints());
    LATTICED_ASSIGN_OR_RETURN(points, CountPoints());
  }
  return Finish();
}

absl::StatusOr<std::vector<Vec3d>> CudaAdaptiveEvaluator::BoxReach() const {
  return ReadReach(parts_.memory.state().reach, plan_->boxes.size(), lane_->stream());
}

absl::Status CudaAdaptiveEvaluator::SetReach(std::span<const Vec3d> reach) {
  return WriteReach(reach, parts_.memory.state().reach, lane_->stream());
}

absl::Status CudaAdaptiveEvaluator::ShareEdges(std::span<const uint32_t> edges) {
  if (edges.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(
      shared_,
      CudaSharedBounds::Create(edges, parts_.memory.state().edge_maxima, *context_, lane_));
  return absl::OkStatus();
}

absl::Status CudaAdaptiveEvaluator::Bound(std::span<const Vec3d> control_points,
                                          const QuantisationBox& box,
                                          std::span<const uint32_t> chunks) {
  LATTICED_RETURN_IF_ERROR(Prepare(control_points, box, chunks));
  LATTICED_RETURN_IF_ERROR(LaunchBounds(/*with_patterns=*/false));
  return shared_ ? shared_->Take() : absl::OkStatus();
}

absl::StatusOr<std::span<const float>> CudaAdaptiveEvaluator::SharedBounds() const {
  if (!shared_) return std::span<const float>();
  return shared_->Wait();
}

absl::Status CudaAdaptiveEvaluator::Choose(double curvature_tolerance,
                                           std::span<const float> shared_bounds) {
  if (shared_) {
    LATTICED_RETURN_IF_ERROR(shared_->Raise(shared_bounds));
  }
  SetTolerance(curvature_tolerance);
  LATTICED_RETURN_IF_ERROR(LaunchPatterns());
  return LaunchPoints();
}

absl::Status CudaAdaptiveEvaluator::Prepare(std::span<const Vec3d> control_points,
                                            const QuantisationBox& box,
                                            std::span<const uint32_t> chunks) {
  auto& room = parts_.results[1 - results_at_];
  if (room.use_count() > 1) {
    LATTICED_ASSIGN_OR_RETURN(room, BorrowShared(*context_, ResultBytes(*plan_)));
  }
  LATTICED_RETURN_IF_ERROR(parts_.frame.Stage(control_points, chunks));
  frame_ = Frame{box, chunks, LaunchFor(box, chunks)};
  return absl::OkStatus();
}

void CudaAdaptiveEvaluator::SetTolerance(double curvature_tolerance) {
  curvature_tolerance_ = curvature_tolerance;
  frame_->launch.tolerance = static_cast<float>(kFloatShare * curvature_tolerance *
                                                parts_.surface->UnitsPerWorld(frame_->box));
}

absl::Status CudaAdaptiveEvaluator::LaunchBounds(bool with_patterns) {
  const kernels::AdaptiveLaunch& launch = frame_->launch;
  std::vector<AdaptiveStage> stages;
  stages.reserve(kMostBoundStages);
  stages.push_back({parts_.frame.SendCall(), "copy"});
  parts_.surface->AddBoundStages(launch, stages);
  stages.push_back({kernels::EdgeMaximaCall(launch), "maxima"});
  if (with_patterns) stages.push_back({kernels::PatternsCall(launch), "patterns"});
  absl::Status status = parts_.memory.ClearMaxima();
  if (status.ok() && lane_->marks_stages()) {
    for (const AdaptiveStage& stage : stages) status.Update(Launch(stage));
  } else if (status.ok()) {
    std::vector<kernels::KernelCall> calls;
    calls.reserve(stages.size());
    for (const AdaptiveStage& stage : stages) calls.push_back(stage.call);
    status = graph_.Launch(calls, stream());
  }
  status.Update(parts_.frame.Sent());
  return status;
}

absl::Status CudaAdaptiveEvaluator::LaunchPatterns() {
  LATTICED_RETURN_IF_ERROR(parts_.memory.ClearError());
  return Launch({kernels::PatternsCall(frame_->launch), "patterns"});
}

absl::Status CudaAdaptiveEvaluator::LaunchPoints() {
  const DeviceSpan<uint8_t> scratch = parts_.memory.scan_scratch();
  LATTICED_RETURN_IF_ERROR(CudaStatus(
      kernels::LaunchScan(frame_->launch, scratch.data, scratch.size, stream()), "the sums"));
  lane_->Enqueued("scan");
  // The device goes on with the points while it copies, and the host while the device does.
  LATTICED_RETURN_IF_ERROR(parts_.summed.Record(stream()));
  const cudaStream_t copies = parts_.copies.get();
  LATTICED_RETURN_IF_ERROR(parts_.summed.HoldBack(copies));
  const DeviceSpan<const uint8_t> from = parts_.memory.results();
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemcpyAsync(incoming(), from.data, from.size, cudaMemcpyDeviceToHost, copies),
                 "the copy of levels"));
  LATTICED_RETURN_IF_ERROR(parts_.read_back.Record(copies));
  return Launch({parts_.surface->PointsCall(frame_->launch), "points"});
}

absl::StatusOr<uint64_t> CudaAdaptiveEvaluator::CountPoints() const {
  LATTICED_RETURN_IF_ERROR(parts_.read_back.Synchronize());
  return results().chunk_first().back();
}

absl::Status CudaAdaptiveEvaluator::Finish() {
  const uint64_t points = results().chunk_first().back();
  if (points > capacity()) {
    LATTICED_RETURN_IF_ERROR(Grow(points));
  }
  certified_error_ =
      double{results().largest_error()} / parts_.surface->UnitsPerWorld(frame_->box) +
      PointError(frame_->box, GridBits(spec_));
  TakeResults();
  return absl::OkStatus();
}

absl::Status CudaAdaptiveEvaluator::Grow(uint64_t points) {
  // A slice may have more than its share of the most points.
  const uint64_t room = std::max(points, std::min(points + points / 4, most_points_));
  parts_.vertices = {};  // the old ones first: both together might not fit
  LATTICED_ASSIGN_OR_RETURN(parts_.vertices,
                            DeviceBuffer<uint8_t>::Create(context_->memory(), "vertices",
                                                          room * BytesPerPoint(spec_), stream()));
  frame_->launch.fused.output.vertices = parts_.vertices.data();
  frame_->launch.most_points = room;
  return Launch({parts_.surface->PointsCall(frame_->launch), "points"});
}

void CudaAdaptiveEvaluator::TakeResults() {
  constexpr size_t kPatches = limits::kPatchesPerChunk;
  const std::span<const uint32_t> named = frame_->chunks;
  const AdaptiveResults now = results();
  also_changed_.clear();
  if (named.size() == plan_->chunk_count()) return KeepResults();
  const auto is_changed = [&](uint32_t chunk) {
    return !std::ranges::equal(now.codes().subspan(chunk * kPatches, kPatches),
                               codes_.subspan(chunk * kPatches, kPatches));
  };
  size_t next = 0;
  for (uint32_t chunk = 0; chunk < plan_->chunk_count(); ++chunk) {
    if (next < named.size() && named[next] == chunk) {
      ++next;
    } else if (is_changed(chunk)) {
      also_changed_.push_back(chunk);
    }
  }
  KeepResults();
}

void CudaAdaptiveEvaluator::KeepResults() {
  codes_ = results().codes();
  chunk_first_ = results().chunk_first();
  results_at_ = 1 - results_at_;
}

PatternCodes CudaAdaptiveEvaluator::Patterns() const {
  return {parts_.results[results_at_], codes_.first(plan_->patches.size())};
}

DeviceSpan<const uint8_t> CudaAdaptiveEvaluator::Vertices(uint32_t first, uint32_t last) const {
  const size_t bytes = BytesPerPoint(spec_);
  return {parts_.vertices.data() + chunk_first_[first] * bytes,
          (chunk_first_[last] - chunk_first_[first]) * bytes};
}

MemoryUse CudaAdaptiveEvaluator::memory() const {
  MemoryUse use = parts_.surface->memory();
  use["device_levels"] = parts_.memory.size_bytes() + (shared_ ? shared_->DeviceBytes() : 0);
  use["device_vertices"] = parts_.vertices.size_bytes();
  use["device_staging"] = parts_.frame.DeviceBytes();
  use["levels"] = parts_.results[0]->size();
  use["staging"] = parts_.results[1]->size() + parts_.frame.PinnedBytes() +
                   (shared_ ? shared_->PinnedBytes() : 0);
  return use;
}

}  // namespace latticed
