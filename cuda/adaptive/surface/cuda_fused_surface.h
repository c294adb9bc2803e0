// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline under a tolerance: the kernels of cuda/adaptive/adaptive_kernels.h on the polynomials of boxes.
//
// Units    of bounds: world for floats, else shares of the quantisation box
// Errors   those of polynomial_memory.h
// Threads  those of cuda_adaptive_surface.h
#ifndef LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_FUSED_SURFACE_H_
#define LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_FUSED_SURFACE_H_

#include <memory>
#include <utility>
#include <vector>

#include "cuda/adaptive/surface/cuda_adaptive_surface.h"
#include "cuda/fused/polynomial_memory.h"
#include "cuda/plan/device_plan.h"

namespace latticed {

class CudaFusedSurface : public CudaAdaptiveSurface {
 public:
  // `device_plan` was made for kFused. Takes BytesFor from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaAdaptiveSurface>> Create(
      const DeformPlan& plan, std::shared_ptr<const DevicePlan> device_plan, const ViewSpec& spec,
      DeviceReservation& from, cudaStream_t stream);
  static uint64_t BytesFor(const DeformPlan& plan) { return PolynomialMemory::BytesFor(plan); }

  double UnitsPerWorld(const QuantisationBox& box) const override {
    return is_quantised_ ? 1 / box.range : 1;
  }
  void Begin(const QuantisationBox& box, kernels::AdaptiveLaunch& launch) override;
  kernels::KernelCall ReachCall(const kernels::AdaptiveLaunch& launch) const override {
    return kernels::ReachCall(launch);
  }
  void AddBoundStages(const kernels::AdaptiveLaunch& launch,
                      std::vector<AdaptiveStage>& stages) const override;
  kernels::KernelCall PointsCall(const kernels::AdaptiveLaunch& launch) const override {
    return kernels::PointsCall(launch);
  }
  MemoryUse memory() const override {
    return {{"device_box_polynomials", polynomials_.size_bytes()}};
  }

 private:
  CudaFusedSurface(Vec3d local_origin, std::shared_ptr<const DevicePlan> device_plan,
                   bool is_quantised, PolynomialMemory polynomials)
      : local_origin_(local_origin),
        device_plan_(std::move(device_plan)),
        is_quantised_(is_quantised),
        polynomials_(std::move(polynomials)) {}

  const Vec3d local_origin_;
  const std::shared_ptr<const DevicePlan> device_plan_;
  const bool is_quantised_;
  const PolynomialMemory polynomials_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_FUSED_SURFACE_H_
