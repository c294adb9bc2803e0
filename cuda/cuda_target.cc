// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_target.h"

#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/view/checked_view.h"
#include "cuda/adaptive/cuda_adaptive_view.h"
#include "cuda/bounds/cuda_edge_bound_view.h"
#include "cuda/fused/cuda_fused_kernel.h"
#include "cuda/gemm/cuda_control_nets.h"
#include "cuda/gemm/cuda_gemm_kernel.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_view.h"

namespace latticed {
namespace {

// Patches that are evaluated in 50 us. Scenes up to this size get streams of greater priority, so
// their blocks start before those of larger scenes.
constexpr size_t kSmallScene = 65'536;

class CudaTarget : public DeformTarget {
 public:
  CudaTarget(std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
             std::shared_ptr<CudaContext> context, std::shared_ptr<DevicePlan> device_plan)
      : plan_(std::move(plan)),
        pipeline_(pipeline),
        context_(std::move(context)),
        device_plan_(std::move(device_plan)) {}

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return pipeline_; }
  bool has_edge_bounds() const override { return pipeline_ == Pipeline::kFused; }

  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    LATTICED_RETURN_IF_ERROR(Validate(spec));
    LATTICED_RETURN_IF_ERROR(CheckSupported(*this, spec));
    const DeviceGuard guard(context_->device());
    if (spec.format == VertexFormat::kEdgeBounds) return CreateEdgeBoundView(spec);
    if (spec.tolerance > 0) return CreateAdaptiveView(spec);
    return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
      LATTICED_ASSIGN_OR_RETURN(auto lane, context_->lanes().Borrow(Priority()));
      LATTICED_ASSIGN_OR_RETURN(auto room,
                                DeviceReservation::Create(context_->memory(), "the view",
                                                          [&] { return ViewBytes(spec, *lane); }));
      LATTICED_ASSIGN_OR_RETURN(auto kernel, CreateKernel(spec, lane, room));
      return CudaView::Create(plan_, spec, context_, std::move(lane), std::move(kernel), room);
    });
  }

  // Runs on a lane of its own and waits for it.
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    LATTICED_RETURN_IF_ERROR(CheckControlNets(*plan_, control_points, first, last));
    if (first == last) return std::vector<double>();
    const DeviceGuard guard(context_->device());
    return CatchBadAlloc("the control nets", [&]() -> absl::StatusOr<std::vector<double>> {
      return CudaControlNets(plan_, *device_plan_, *context_, control_points, first, last);
    });
  }

  ViewTraits Traits(const ViewSpec& spec) const override {
    if (spec.format == VertexFormat::kEdgeBounds) {
      return {.on_device = true,
              .host_bytes = CudaEdgeBoundView::HostBytesFor(*plan_),
              .encode_batch = plan_->chunk_count()};
    }
    const bool adaptive = spec.tolerance > 0;
    return {.on_device = true,
            .host_bytes = adaptive ? CudaAdaptiveView::HostBytesFor(*plan_)
                                   : CudaView::HostBytesFor(*plan_, spec),
            .encoder_bytes = EncoderBytesOf(*plan_, spec, *context_->encoder(), context_->arena()),
            .encode_batch = adaptive ? CudaAdaptiveView::EncodeBatch(*context_)
                                     : CudaView::EncodeBatch(*context_)};
  }

  MemoryUse memory() const override {
    return {{"plan", plan_->MemoryBytes() + device_plan_->HostMemoryBytes()},
            {"device_plan", device_plan_->MemoryBytes()}};
  }

  DeviceUse device_use() const override {
    return {{context_->device(), device_plan_->MemoryBytes()}};
  }

 private:
  // The device memory that a new view on `lane` allocates: its own, and shared tables that do not
  // exist yet. Excludes what GEMM pipelines allocate at the first evaluation.
  uint64_t ViewBytes(const ViewSpec& spec, const CudaLane& lane) const {
    const bool fused = pipeline_ == Pipeline::kFused;
    const uint64_t of_kernel = fused
                                   ? CudaFusedKernel::DeviceBytesFor(*plan_)
                                   : CudaGemmStages::BytesToCome(pipeline_, plan_->surface_degree(),
                                                                 spec.segments, *context_, lane);
    const size_t own_order = fused ? CudaFusedKernel::LaneOrderBytes(*plan_, spec) : 0;
    return device_plan_->BytesToCome(spec.normals == NormalMode::kSmooth) + of_kernel +
           CudaView::DeviceBytesFor(*plan_, spec, own_order,
                                    device_plan_->chunk_needs() != nullptr);
  }

  absl::StatusOr<std::unique_ptr<DeformView>> CreateAdaptiveView(const ViewSpec& spec) const {
    return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
      LATTICED_ASSIGN_OR_RETURN(auto lane, context_->lanes().Borrow(Priority()));
      LATTICED_ASSIGN_OR_RETURN(const uint64_t own,
                                CudaAdaptiveEvaluator::DeviceBytesFor(*plan_, pipeline_, spec));
      LATTICED_ASSIGN_OR_RETURN(
          auto room, DeviceReservation::Create(context_->memory(), "the view", [&] {
            return own + StageBytes() +
                   device_plan_->BytesToCome(spec.normals == NormalMode::kSmooth);
          }));
      LATTICED_ASSIGN_OR_RETURN(auto evaluator,
                                CudaAdaptiveEvaluator::Create(plan_, device_plan_, pipeline_, spec,
                                                              context_, lane, room));
      return std::make_unique<CudaAdaptiveView>(plan_, spec, context_, std::move(lane),
                                                std::move(evaluator));
    });
  }

  // Of the stage that control nets need, where it is not made yet.
  uint64_t StageBytes() const {
    return pipeline_ == Pipeline::kFused ? 0
                                         : context_->StageBytesToCome(plan_->surface_degree(), 1);
  }

  absl::StatusOr<std::unique_ptr<DeformView>> CreateEdgeBoundView(const ViewSpec& spec) const {
    return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
      LATTICED_ASSIGN_OR_RETURN(auto lane, context_->lanes().Borrow(Priority()));
      LATTICED_ASSIGN_OR_RETURN(
          auto room, DeviceReservation::Create(context_->memory(), "the view", [&] {
            return CudaEdgeBoundView::DeviceBytesFor(*plan_) + device_plan_->BytesToCome(false);
          }));
      return CudaEdgeBoundView::Create(plan_, device_plan_, spec, context_, std::move(lane), room);
    });
  }

  StreamPriority Priority() const {
    return plan_->patches.size() <= kSmallScene ? StreamPriority::kGreatest
                                                : StreamPriority::kLeast;
  }

  absl::StatusOr<std::unique_ptr<CudaVertexKernel>> CreateKernel(
      const ViewSpec& spec, const std::shared_ptr<CudaLane>& lane, DeviceReservation& from) {
    if (pipeline_ == Pipeline::kFused) {
      return CudaFusedKernel::Create(plan_, device_plan_, spec, *context_, lane, from);
    }
    return CudaGemmKernel::Create(plan_, device_plan_, pipeline_, spec, context_, lane, from);
  }

  std::shared_ptr<const DeformPlan> plan_;
  Pipeline pipeline_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<DevicePlan> device_plan_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<DeformTarget>> MakeCudaTarget(std::shared_ptr<const DeformPlan> plan,
                                                             Pipeline pipeline,
                                                             std::shared_ptr<CudaContext> context) {
  LATTICED_RETURN_IF_ERROR(CheckSupported(*plan, pipeline));
  const DeviceGuard guard(context->device());
  return CatchBadAlloc("the plan", [&]() -> absl::StatusOr<std::shared_ptr<DeformTarget>> {
    LATTICED_ASSIGN_OR_RETURN(auto device_plan, DevicePlan::Create(plan, pipeline, context));
    return std::make_shared<CudaTarget>(std::move(plan), pipeline, std::move(context),
                                        std::move(device_plan));
  });
}

}  // namespace latticed
