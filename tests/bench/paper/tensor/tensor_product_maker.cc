// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/tensor/tensor_product_maker.h"

#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "tests/bench/paper/tensor/tensor_product_launch.h"

namespace latticed::bench {
namespace {

constexpr char kPurpose[] = "comparator";

}  // namespace

TensorProductMaker::TensorProductMaker(size_t most_lines, DeviceLattice lattice, Buffers buffers)
    : most_lines_(most_lines), lattice_(std::move(lattice)), buffers_(std::move(buffers)) {}

absl::StatusOr<std::unique_ptr<TensorProductMaker>> TensorProductMaker::Create(
    const std::shared_ptr<const DeformPlan>& plan, const TensorSurfaces& surfaces,
    CudaContext& context) {
  const DeviceGuard guard(context.device());
  LATTICED_ASSIGN_OR_RETURN(auto lattice, DeviceLattice::Create(plan, context));
  const std::vector<TensorInverse> inverse{MakeTensorInverse()};
  const size_t count = surfaces.count();
  const cudaStream_t stream = lattice.stream();
  Buffers buffers;
  absl::Status status;
  const auto keep = [&](auto made, auto& to) {
    status.Update(made.status());
    if (made.ok()) to = *std::move(made);
  };
  const auto& memory = context.memory();
  keep(DeviceBuffer<TensorSurface>::Upload(memory, kPurpose, surfaces.surfaces, stream),
       buffers.surfaces);
  keep(DeviceBuffer<TensorLine>::Upload(memory, kPurpose, surfaces.lines, stream), buffers.lines);
  keep(DeviceBuffer<TensorPoint>::Upload(memory, kPurpose, surfaces.points, stream),
       buffers.points);
  keep(DeviceBuffer<TensorInverse>::Upload(memory, kPurpose, inverse, stream), buffers.inverse);
  keep(DeviceBuffer<Vec3d>::Create(memory, kPurpose, count, stream), buffers.centres);
  keep(DeviceBuffer<float>::Create(memory, kPurpose, count * 3 * kTensorNet, stream),
       buffers.control);
  keep(DeviceBuffer<TensorVertex>::Create(memory, kPurpose, surfaces.points.size(), stream),
       buffers.vertices);
  status.Update(lattice.lane().stream().Synchronize("the comparator's tables"));
  if (!status.ok()) return status;
  return std::unique_ptr<TensorProductMaker>(
      new TensorProductMaker(surfaces.most_lines, std::move(lattice), std::move(buffers)));
}

absl::Status TensorProductMaker::Enqueue(std::span<const Vec3d> control_points) {
  LATTICED_RETURN_IF_ERROR(lattice_.Send(control_points));
  lane().Enqueued("copy");
  const TensorJob job{.surfaces = buffers_.surfaces.data(),
                      .count = buffers_.centres.size(),
                      .lines = buffers_.lines.data(),
                      .points = buffers_.points.data(),
                      .inverse = buffers_.inverse.data(),
                      .volume = lattice_.volume(),
                      .centres = buffers_.centres.data(),
                      .control = buffers_.control.data(),
                      .vertices = buffers_.vertices.data()};
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(LaunchTensorControl(job, lattice_.stream()), "the comparator's control points"));
  lane().Enqueued("control points");
  return CudaStatus(LaunchTensorTessellation(job, most_lines_, lattice_.stream()),
                    "the comparator's vertices");
}

absl::StatusOr<std::vector<TensorVertex>> TensorProductMaker::Download() const {
  return lattice_.Download(buffers_.vertices, "the comparator's vertices");
}

}  // namespace latticed::bench
