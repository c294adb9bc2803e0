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
#include "cuda/device/cuda_status.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {
namespace {

// Of the tolerance. Rounding of an error in float32 takes less than what is left.
constexpr double kFloatShare = 1 - 1e-5;
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

// The units of the polynomials in world units.
double UnitsPerWorld(const ViewSpec& spec, const QuantisationBox& box) {
  return spec.format == VertexFormat::kQuantised ? 1 / box.range : 1;
}

}  // namespace

absl::StatusOr<uint64_t> CudaAdaptiveEvaluator::DeviceBytesFor(const DeformPlan& plan,
                                                               const ViewSpec& spec) {
  LATTICED_ASSIGN_OR_RETURN(const uint64_t memory, AdaptiveMemory::BytesFor(plan));
  return memory + CudaFrame::DeviceBytesFor(plan, false) + PolynomialMemory::BytesFor(plan) +
         FirstCapacity(plan, spec) * BytesPerPoint(spec);
}

uint64_t CudaAdaptiveEvaluator::HostBytesFor(const DeformPlan& plan) {
  return 2 * PinnedMemory::BlockBytes(ResultBytes(plan)) + CudaFrame::PinnedBytesFor(plan, false) +
         plan.chunk_count() * sizeof(uint32_t);
}

absl::StatusOr<std::unique_ptr<CudaAdaptiveEvaluator>> CudaAdaptiveEvaluator::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
    const ViewSpec& spec, std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
    DeviceReservation& from) {
  const cudaStream_t stream = lane->stream().get();
  LATTICED_ASSIGN_OR_RETURN(const auto tables,
                            device_plan->Tables(spec.normals == NormalMode::kSmooth, from));
  LATTICED_ASSIGN_OR_RETURN(auto frame, CudaFrame::Create(plan, nullptr, *context, lane, from));
  LATTICED_ASSIGN_OR_RETURN(auto polynomials, PolynomialMemory::Create(*plan, from, stream));
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
      {std::move(frame), std::move(polynomials), std::move(memory), std::move(vertices),
       std::move(results), std::move(copies), std::move(summed), std::move(read_back)}));
  if (is_empty) return evaluator;
  LATTICED_RETURN_IF_ERROR(
      evaluator->Launch({kernels::ReachCall(evaluator->LaunchFor({}, {})), "reach"}));
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

absl::Status CudaAdaptiveEvaluator::Launch(Stage stage) const {
  LATTICED_RETURN_IF_ERROR(CudaStatus(stage.call.Launch(stream()), "an evaluation"));
  lane_->Enqueued(stage.name);
  return absl::OkStatus();
}

kernels::AdaptiveLaunch CudaAdaptiveEvaluator::LaunchFor(const QuantisationBox& box,
                                                         std::span<const uint32_t> chunks) const {
  const bool floats = spec_.format == VertexFormat::kFloat32;
  const Vec3d offset = floats ? Vec3d{} : (plan_->local_origin - box.origin) / box.range;
  return {
      .fused = {.plan = tables_,
                .tables = device_plan_->fused_tables(),
                .polynomials = parts_.polynomials.polynomials(UnitsPerWorld(spec_, box), offset),
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
  frame_->launch.tolerance =
      static_cast<float>(kFloatShare * curvature_tolerance * UnitsPerWorld(spec_, frame_->box));
}

absl::Status CudaAdaptiveEvaluator::LaunchBounds(bool with_patterns) {
  const kernels::AdaptiveLaunch& launch = frame_->launch;
  const kernels::FusedLaunch& fused = launch.fused;
  std::array all{Stage{parts_.frame.SendCall(), "copy"},
                 Stage{kernels::BoxPolynomialsCall(fused.plan, fused.tables, fused.control_points,
                                                   {nullptr, 0}, fused.polynomials),
                       "polynomials"},
                 Stage{kernels::SlackCall(launch), "slack"},
                 Stage{kernels::BoundsCall(launch), "bounds"},
                 Stage{kernels::EdgeMaximaCall(launch), "maxima"},
                 Stage{kernels::PatternsCall(launch), "patterns"}};
  const std::span stages = std::span(all).first(with_patterns ? all.size() : all.size() - 1);
  absl::Status status = parts_.memory.ClearMaxima();
  if (status.ok() && lane_->marks_stages()) {
    for (const Stage& stage : stages) status.Update(Launch(stage));
  } else if (status.ok()) {
    std::array<kernels::KernelCall, all.size()> calls;
    std::ranges::transform(stages, calls.begin(), &Stage::call);
    status = graph_.Launch(std::span(calls).first(stages.size()), stream());
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
  return Launch({kernels::PointsCall(frame_->launch), "points"});
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
  certified_error_ = double{results().largest_error()} / UnitsPerWorld(spec_, frame_->box) +
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
  return Launch({kernels::PointsCall(frame_->launch), "points"});
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
  return {{"device_box_polynomials", parts_.polynomials.size_bytes()},
          {"device_levels", parts_.memory.size_bytes() + (shared_ ? shared_->DeviceBytes() : 0)},
          {"device_vertices", parts_.vertices.size_bytes()},
          {"device_staging", parts_.frame.DeviceBytes()},
          {"levels", parts_.results[0]->size()},
          {"staging", parts_.results[1]->size() + parts_.frame.PinnedBytes() +
                          (shared_ ? shared_->PinnedBytes() : 0)}};
}

}  // namespace latticed
