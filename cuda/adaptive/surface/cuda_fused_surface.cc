// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/surface/cuda_fused_surface.h"

#include "core/base/status_macros.h"

namespace latticed {

absl::StatusOr<std::unique_ptr<CudaAdaptiveSurface>> CudaFusedSurface::Create(
    const DeformPlan& plan, std::shared_ptr<const DevicePlan> device_plan, const ViewSpec& spec,
    DeviceReservation& from, cudaStream_t stream) {
  LATTICED_ASSIGN_OR_RETURN(auto polynomials, PolynomialMemory::Create(plan, from, stream));
  return std::unique_ptr<CudaAdaptiveSurface>(
      new CudaFusedSurface(plan.local_origin, std::move(device_plan),
                           spec.format == VertexFormat::kQuantised, std::move(polynomials)));
}

void CudaFusedSurface::Begin(const QuantisationBox& box, kernels::AdaptiveLaunch& launch) {
  const Vec3d offset = is_quantised_ ? (local_origin_ - box.origin) / box.range : Vec3d{};
  launch.fused.tables = device_plan_->fused_tables();
  launch.fused.polynomials = polynomials_.polynomials(UnitsPerWorld(box), offset);
}

void CudaFusedSurface::AddBoundStages(const kernels::AdaptiveLaunch& launch,
                                      std::vector<AdaptiveStage>& stages) const {
  const kernels::FusedLaunch& fused = launch.fused;
  stages.push_back({kernels::BoxPolynomialsCall(fused.plan, fused.tables, fused.control_points,
                                                {nullptr, 0}, fused.polynomials),
                    "polynomials"});
  stages.push_back({kernels::SlackCall(launch), "slack"});
  stages.push_back({kernels::BoundsCall(launch), "bounds"});
}

}  // namespace latticed
