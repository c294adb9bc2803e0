// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The matrix pipelines under a tolerance: bounds of control nets and points of the definition, in double
// (sampled_kernels.h). Its tables take 16 bytes an edge and a vertex of the plan.
//
// Units    of bounds: world
// Errors   those of StageMatrices::Get and table_upload.h
// Threads  those of cuda_adaptive_surface.h
#ifndef LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_SAMPLED_SURFACE_H_
#define LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_SAMPLED_SURFACE_H_

#include <memory>
#include <vector>

#include "cuda/adaptive/surface/cuda_adaptive_surface.h"
#include "cuda/adaptive/surface/sampled_kernels.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_stage.h"
#include "cuda/plan/device_plan.h"

namespace latticed {

class CudaSampledSurface : public CudaAdaptiveSurface {
 public:
  // `device_plan` was not made for kFused. Takes BytesFor, and what the stage takes, from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaAdaptiveSurface>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<const DevicePlan> device_plan,
      const ViewSpec& spec, CudaContext& context, DeviceReservation& from, cudaStream_t stream);
  static uint64_t BytesFor(const DeformPlan& plan);

  double UnitsPerWorld(const QuantisationBox&) const override { return 1; }
  void Begin(const QuantisationBox& box, kernels::AdaptiveLaunch& launch) override;
  kernels::KernelCall ReachCall(const kernels::AdaptiveLaunch&) const override { return {}; }
  void AddBoundStages(const kernels::AdaptiveLaunch& launch,
                      std::vector<AdaptiveStage>& stages) const override {
    stages.push_back({kernels::SampledBoundsCall(LaunchOf(launch)), "bounds"});
  }
  kernels::KernelCall PointsCall(const kernels::AdaptiveLaunch& launch) const override {
    return kernels::SampledPointsCall(LaunchOf(launch));
  }
  MemoryUse memory() const override {
    return {{"device_edges", block_.size_bytes()},
            {"device_stage_matrices", stage_->MemoryBytes()}};
  }

 private:
  CudaSampledSurface(std::shared_ptr<const DeformPlan> plan,
                     std::shared_ptr<const DevicePlan> device_plan, const ViewSpec& spec,
                     std::shared_ptr<const DeviceStage> stage);
  kernels::SampledLaunch LaunchOf(const kernels::AdaptiveLaunch& launch) const;

  const std::shared_ptr<const DeformPlan> plan_;
  const std::shared_ptr<const DevicePlan> device_plan_;
  const ViewSpec spec_;
  const std::shared_ptr<const DeviceStage> stage_;
  DeviceBuffer<uint8_t> block_;  // of the tables' edges and vertices
  kernels::SampledTables tables_{};
  VertexWriter writer_;  // of the evaluation that runs
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_SAMPLED_SURFACE_H_
