// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/tensor_product_kernel.h"

#include <utility>
#include <vector>

#include "core/view/view_layout.h"
#include "cuda/device/cuda_status.h"
#include "tests/bench/tensor_product_launch.h"
#include "tests/bench/tensor_tables.h"

namespace latticed::bench {
namespace {

constexpr char kPurpose[] = "comparator";

}  // namespace

TensorProductKernel::TensorProductKernel(std::shared_ptr<const DeformPlan> plan,
                                         const ViewSpec& spec, std::shared_ptr<CudaLane> lane,
                                         Buffers buffers)
    : plan_(std::move(plan)), spec_(spec), lane_(std::move(lane)), buffers_(std::move(buffers)) {}

absl::StatusOr<std::unique_ptr<TensorProductKernel>> TensorProductKernel::Create(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec, CudaContext& context,
    std::shared_ptr<CudaLane> lane) {
  if (plan->structure.patch_degree() != kTensorDegree) {
    return absl::UnimplementedError("the comparator knows patches of degree 6 alone");
  }
  std::vector<double> knots;
  for (const auto& axis : plan->structure.knots)
    knots.insert(knots.end(), axis.begin(), axis.end());
  const std::vector<TensorPatch> patches = MakeTensorPatches(*plan);
  const std::vector<TensorTables> tables{MakeTensorTables(spec.segments)};
  const cudaStream_t stream = lane->stream().get();
  Buffers buffers;
  absl::Status status;
  const auto keep = [&](auto made, auto& to) {
    status.Update(made.status());
    if (made.ok()) to = *std::move(made);
  };
  const auto& memory = context.memory();
  keep(DeviceBuffer<double>::Upload(memory, kPurpose, knots, stream), buffers.knots);
  keep(DeviceBuffer<TensorPatch>::Upload(memory, kPurpose, patches, stream), buffers.patches);
  keep(DeviceBuffer<TensorTables>::Upload(memory, kPurpose, tables, stream), buffers.tables);
  keep(DeviceBuffer<Vec3d>::Create(memory, kPurpose, patches.size(), stream), buffers.centres);
  keep(DeviceBuffer<float>::Create(memory, kPurpose, patches.size() * 3 * kTensorNet, stream),
       buffers.control);
  status.Update(lane->stream().Synchronize("the comparator's tables"));
  if (!status.ok()) return status;
  return std::unique_ptr<TensorProductKernel>(
      new TensorProductKernel(std::move(plan), spec, std::move(lane), std::move(buffers)));
}

VolumeView TensorProductKernel::Volume(const Vec3d* control_points) const {
  VolumeView volume{.control_points = control_points};
  const double* knots = buffers_.knots.data();
  for (size_t a = 0; a < 3; ++a) {
    volume.degree[a] = plan_->structure.degree[a];
    volume.size[a] = plan_->structure.size[a];
    volume.knots[a] = knots;
    knots += plan_->structure.knots[a].size();
  }
  return volume;
}

absl::Status TensorProductKernel::Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                                           std::span<const uint32_t> /*chunks: always all*/,
                                           DeviceSpan<uint8_t> vertices) {
  if (auto s = frame.Send(); !s.ok()) return s;
  lane_->Enqueued("copy");
  const TensorJob job{.patches = buffers_.patches.data(),
                      .count = buffers_.patches.size(),
                      .volume = Volume(frame.control_points().data),
                      .tables = buffers_.tables.data(),
                      .segments = spec_.segments,
                      .centres = buffers_.centres.data(),
                      .control = buffers_.control.data(),
                      .layout = MakeVertexLayout(*plan_, spec_),
                      .writer = MakeVertexWriter(*plan_, spec_, box),
                      .vertices = vertices.data};
  const cudaStream_t stream = lane_->stream().get();
  if (auto s = CudaStatus(LaunchTensorControl(job, stream), "the comparator's control points");
      !s.ok()) {
    return s;
  }
  lane_->Enqueued("control points");
  return CudaStatus(LaunchTensorTessellation(job, stream), "the comparator's vertices");
}

MemoryUse TensorProductKernel::memory() const {
  return {{kPurpose, buffers_.knots.size_bytes() + buffers_.patches.size_bytes() +
                         buffers_.tables.size_bytes() + buffers_.centres.size_bytes() +
                         buffers_.control.size_bytes()}};
}

absl::StatusOr<std::unique_ptr<DeformView>> MakeTensorProductView(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
    std::shared_ptr<CudaContext> context) {
  const DeviceGuard guard(context->device());
  auto lane = context->lanes().Borrow();
  if (!lane.ok()) return lane.status();
  auto kernel = TensorProductKernel::Create(plan, spec, *context, *lane);
  if (!kernel.ok()) return kernel.status();
  auto view = CudaView::Create(std::move(plan), spec, std::move(context), *std::move(lane),
                               *std::move(kernel));
  if (!view.ok()) return view.status();
  return std::unique_ptr<DeformView>(*std::move(view));
}

}  // namespace latticed::bench
