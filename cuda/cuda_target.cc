// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_target.h"

#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/view/checked_view.h"
#include "cuda/fused/cuda_fused_kernel.h"
#include "cuda/gemm/cuda_control_nets.h"
#include "cuda/gemm/cuda_gemm_kernel.h"
#include "cuda/view/cuda_view.h"

namespace latticed {
namespace {

// Patches that are evaluated in 50 us: such a scene does not wait until all of a larger one has begun.
constexpr size_t kSmallScene = 65'536;

}  // namespace

CudaTarget::CudaTarget(std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
                       std::shared_ptr<CudaContext> context)
    : plan_(std::move(plan)), pipeline_(pipeline), context_(std::move(context)) {}

absl::StatusOr<std::shared_ptr<DeformTarget>> CudaTarget::Create(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
    std::shared_ptr<CudaContext> context) {
  const DeviceGuard guard(context->device());
  using Made = absl::StatusOr<std::shared_ptr<DeformTarget>>;
  return CatchBadAlloc("the plan", [&]() -> Made {
    std::shared_ptr<CudaTarget> target(
        new CudaTarget(std::move(plan), pipeline, std::move(context)));
    LATTICED_ASSIGN_OR_RETURN(target->device_plan_,
                              DevicePlan::Create(target->plan_, pipeline, target->context_));
    return target;
  });
}

absl::StatusOr<std::unique_ptr<DeformView>> CudaTarget::CreateView(const ViewSpec& spec) {
  LATTICED_RETURN_IF_ERROR(Validate(spec));
  const DeviceGuard guard(context_->device());
  return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
    LATTICED_ASSIGN_OR_RETURN(auto lane, context_->lanes().Borrow(Priority()));
    LATTICED_ASSIGN_OR_RETURN(auto room,
                              DeviceReservation::Create(context_->memory(), "the view",
                                                        [&] { return ViewBytes(spec, *lane); }));
    LATTICED_ASSIGN_OR_RETURN(auto kernel, CreateKernel(spec, lane, room));
    return CudaView::Create(plan_, spec, context_, std::move(lane), std::move(kernel), room);
  });
}

uint64_t CudaTarget::ViewBytes(const ViewSpec& spec, const CudaLane& lane) const {
  const bool fused = pipeline_ == Pipeline::kFused;
  const uint64_t of_kernel =
      fused ? CudaFusedKernel::DeviceBytesFor(*plan_)
            : CudaGemmStages::BytesToCome(pipeline_, plan_->structure.patch_degree(), spec.segments,
                                          *context_, lane);
  const size_t own_order = fused ? CudaFusedKernel::LaneOrderBytes(*plan_, spec) : 0;
  return device_plan_->BytesToCome(spec.normals == NormalMode::kSmooth) + of_kernel +
         CudaView::DeviceBytesFor(*plan_, spec, own_order, device_plan_->chunk_needs() != nullptr);
}

StreamPriority CudaTarget::Priority() const {
  return plan_->patches.size() <= kSmallScene ? StreamPriority::kGreatest : StreamPriority::kLeast;
}

absl::StatusOr<std::unique_ptr<CudaVertexKernel>> CudaTarget::CreateKernel(
    const ViewSpec& spec, const std::shared_ptr<CudaLane>& lane, DeviceReservation& from) {
  if (pipeline_ == Pipeline::kFused) {
    return CudaFusedKernel::Create(plan_, device_plan_, spec, *context_, lane, from);
  }
  return CudaGemmKernel::Create(plan_, device_plan_, pipeline_, spec, context_, lane, from);
}

absl::StatusOr<std::vector<double>> CudaTarget::ControlNets(std::span<const Vec3d> control_points,
                                                            size_t first, size_t last) {
  LATTICED_RETURN_IF_ERROR(CheckControlNets(*plan_, control_points, first, last));
  if (first == last) return std::vector<double>();
  const DeviceGuard guard(context_->device());
  return CatchBadAlloc("the control nets", [&] {
    return CudaControlNets(plan_, *device_plan_, *context_, control_points, first, last);
  });
}

ViewTraits CudaTarget::Traits(const ViewSpec& spec) const {
  return {.on_device = true,
          .host_bytes = CudaView::HostBytesFor(*plan_, spec),
          .encoder_bytes = EncoderBytesOf(*plan_, spec, *context_->encoder(), context_->arena()),
          .encode_batch = CudaView::EncodeBatch(*context_)};
}

MemoryUse CudaTarget::memory() const {
  return {{"plan", plan_->MemoryBytes() + device_plan_->HostMemoryBytes()},
          {"device_plan", device_plan_->MemoryBytes()}};
}

}  // namespace latticed
