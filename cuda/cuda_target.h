// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan prepared for one pipeline on one device. Twin of core/cpu/cpu_target.h. Its views keep it
// alive through the plan, the device's tables and the context.
#ifndef LATTICED_CUDA_CUDA_TARGET_H_
#define LATTICED_CUDA_CUDA_TARGET_H_

#include <memory>
#include <vector>

#include "core/backend.h"
#include "cuda/device/cuda_context.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

class CudaTarget : public DeformTarget {
 public:
  // kResourceExhausted where the tables do not fit.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<DeformTarget>> Create(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
      std::shared_ptr<CudaContext> context);

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return pipeline_; }
  ViewTraits Traits(const ViewSpec& spec) const override;
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override;
  // Waits for a lane of its own.
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override;
  MemoryUse memory() const override;
  DeviceUse device_use() const override {
    return {{context_->device(), device_plan_->MemoryBytes()}};
  }

 private:
  CudaTarget(std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
             std::shared_ptr<CudaContext> context);
  // All that a view on `lane` has to itself on the device, and what it is the first to need of that
  // which views share; not what GEMM pipelines take at the first evaluation.
  uint64_t ViewBytes(const ViewSpec& spec, const CudaLane& lane) const;
  StreamPriority Priority() const;
  absl::StatusOr<std::unique_ptr<CudaVertexKernel>> CreateKernel(
      const ViewSpec& spec, const std::shared_ptr<CudaLane>& lane, DeviceReservation& from);

  std::shared_ptr<const DeformPlan> plan_;
  Pipeline pipeline_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<DevicePlan> device_plan_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_CUDA_TARGET_H_
