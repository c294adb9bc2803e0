// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/surface/cuda_sampled_surface.h"

#include <utility>

#include "core/adaptive/net_slack.h"
#include "core/base/status_macros.h"
#include "core/view/view_layout.h"
#include "cuda/device/table_upload.h"

namespace latticed {
namespace {

static_assert(kernels::kNoSharedSeam == kNoIndex);
// Control nets do not depend on the segments.
constexpr int kAnySegments = 1;

std::vector<kernels::SharedPlace> PackEdges(const DeformPlan& plan) {
  std::vector<kernels::SharedPlace> packed;
  packed.reserve(plan.edges.size());
  for (const PlanEdge& e : plan.edges) {
    packed.push_back({{e.vertex[0], e.vertex[1]}, e.box, e.seam});
  }
  return packed;
}

std::vector<kernels::SharedPlace> PackVertexPlaces(const DeformPlan& plan) {
  std::vector<kernels::SharedPlace> packed;
  packed.reserve(plan.vertices.size());
  for (uint32_t v = 0; v < plan.vertices.size(); ++v) {
    packed.push_back({{v, v}, plan.vertices[v].box, plan.vertices[v].seam});
  }
  return packed;
}

}  // namespace

absl::StatusOr<std::unique_ptr<CudaAdaptiveSurface>> CudaSampledSurface::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<const DevicePlan> device_plan,
    const ViewSpec& spec, CudaContext& context, DeviceReservation& from, cudaStream_t stream) {
  LATTICED_ASSIGN_OR_RETURN(auto stage, context.Stage(plan->surface_degree(), kAnySegments, from));
  std::unique_ptr<CudaSampledSurface> surface(
      new CudaSampledSurface(std::move(plan), std::move(device_plan), spec, std::move(stage)));
  TableUpload upload;
  upload.Add(PackEdges(*surface->plan_), surface->tables_.edges);
  upload.Add(PackVertexPlaces(*surface->plan_), surface->tables_.vertices);
  upload.Add({surface->device_plan_->turned()}, surface->tables_.turned);
  LATTICED_ASSIGN_OR_RETURN(surface->block_, upload.Send(from, "levels", stream));
  // The tables' memory on the host ends here.
  if (const auto error = cudaStreamSynchronize(stream); error != cudaSuccess) {
    return CudaStatus(error, "the tables of the levels");
  }
  return std::unique_ptr<CudaAdaptiveSurface>(std::move(surface));
}

uint64_t CudaSampledSurface::BytesFor(const DeformPlan& plan) {
  return TableUpload::BlockBytes({plan.edges.size() * sizeof(kernels::SharedPlace),
                                  plan.vertices.size() * sizeof(kernels::SharedPlace),
                                  sizeof(kernels::TurnedTables)});
}

CudaSampledSurface::CudaSampledSurface(std::shared_ptr<const DeformPlan> plan,
                                       std::shared_ptr<const DevicePlan> device_plan,
                                       const ViewSpec& spec,
                                       std::shared_ptr<const DeviceStage> stage)
    : plan_(std::move(plan)),
      device_plan_(std::move(device_plan)),
      spec_(spec),
      stage_(std::move(stage)) {
  tables_.samples = stage_->samples();
  tables_.inverse = stage_->inverse().data;
  tables_.degree = stage_->degree();
  tables_.m = static_cast<int>(stage_->m());
  const NetSlack slack(*plan_);
  tables_.slack_of_net = slack.of_net();
  tables_.mesh_reach = slack.mesh_reach();
}

void CudaSampledSurface::Begin(const QuantisationBox& box, kernels::AdaptiveLaunch&) {
  writer_ = MakeVertexWriter(*plan_, spec_, box);
}

kernels::SampledLaunch CudaSampledSurface::LaunchOf(const kernels::AdaptiveLaunch& launch) const {
  return {.adaptive = launch,
          .tables = tables_,
          .writer = writer_,
          .point_bytes = BytesPerPoint(spec_),
          .vertices = launch.fused.output.vertices};
}

}  // namespace latticed
