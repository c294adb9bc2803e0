// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/bezier_net/bezier_net_maker.h"

#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "tests/bench/paper/bezier_net/bezier_net_launch.h"

namespace latticed::bench {
namespace {

constexpr char kPurpose[] = "comparator";

}  // namespace

BezierNetMaker::BezierNetMaker(int m, DeviceLattice lattice, Buffers buffers)
    : m_(m), lattice_(std::move(lattice)), buffers_(std::move(buffers)) {}

absl::StatusOr<std::unique_ptr<BezierNetMaker>> BezierNetMaker::Create(
    const std::shared_ptr<const DeformPlan>& plan, CudaContext& context) {
  const DeviceGuard guard(context.device());
  LATTICED_ASSIGN_OR_RETURN(auto lattice, DeviceLattice::Create(plan, context));
  const std::vector<NetPatch> patches = MakeNetPatches(*plan);
  const std::vector<NetTables> tables{MakeNetTables(plan->structure.patch_degree())};
  const int m = tables[0].m;
  const size_t points = patches.size() * static_cast<size_t>(m + 1);
  const cudaStream_t stream = lattice.stream();
  Buffers buffers;
  absl::Status status;
  const auto keep = [&](auto made, auto& to) {
    status.Update(made.status());
    if (made.ok()) to = *std::move(made);
  };
  const auto& memory = context.memory();
  keep(DeviceBuffer<NetPatch>::Upload(memory, kPurpose, patches, stream), buffers.patches);
  keep(DeviceBuffer<NetTables>::Upload(memory, kPurpose, tables, stream), buffers.tables);
  keep(DeviceBuffer<NetPoint>::Create(memory, kPurpose, points, stream), buffers.nets);
  status.Update(lattice.lane().stream().Synchronize("the comparator's tables"));
  if (!status.ok()) return status;
  return std::unique_ptr<BezierNetMaker>(
      new BezierNetMaker(m, std::move(lattice), std::move(buffers)));
}

absl::Status BezierNetMaker::Enqueue(std::span<const Vec3d> control_points) {
  LATTICED_RETURN_IF_ERROR(lattice_.Send(control_points));
  const NetJob job{.patches = buffers_.patches.data(),
                   .count = buffers_.patches.size(),
                   .volume = lattice_.volume(),
                   .tables = buffers_.tables.data(),
                   .nets = buffers_.nets.data()};
  return CudaStatus(LaunchBezierNets(job, m_, lattice_.stream()), "the control nets");
}

absl::StatusOr<std::vector<NetPoint>> BezierNetMaker::Download() const {
  return lattice_.Download(buffers_.nets, "the control nets");
}

}  // namespace latticed::bench
