// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/bezier_net_maker.h"

#include <utility>

#include "cuda/device/cuda_status.h"
#include "tests/bench/bezier_net_launch.h"
#include "tests/bench/tensor_tables.h"

namespace latticed::bench {
namespace {

constexpr char kPurpose[] = "comparator";

}  // namespace

BezierNetMaker::BezierNetMaker(std::shared_ptr<const DeformPlan> plan,
                               std::shared_ptr<CudaLane> lane, CudaFrame frame, Buffers buffers)
    : plan_(std::move(plan)),
      lane_(std::move(lane)),
      frame_(std::move(frame)),
      buffers_(std::move(buffers)) {}

absl::StatusOr<std::unique_ptr<BezierNetMaker>> BezierNetMaker::Create(
    std::shared_ptr<const DeformPlan> plan, CudaContext& context) {
  const DeviceGuard guard(context.device());
  auto lane = context.lanes().Borrow();
  if (!lane.ok()) return lane.status();
  auto frame = CudaFrame::Create(plan, context, *lane);
  if (!frame.ok()) return frame.status();
  std::vector<double> knots;
  for (const auto& axis : plan->structure.knots) {
    knots.insert(knots.end(), axis.begin(), axis.end());
  }
  const std::vector<TensorPatch> patches = MakeTensorPatches(*plan);
  const std::vector<NetTables> tables{MakeNetTables(plan->structure.patch_degree())};
  const size_t points = patches.size() * static_cast<size_t>(tables[0].m + 1);
  const cudaStream_t stream = (*lane)->stream().get();
  Buffers buffers;
  absl::Status status;
  const auto keep = [&](auto made, auto& to) {
    status.Update(made.status());
    if (made.ok()) to = *std::move(made);
  };
  const auto& memory = context.memory();
  keep(DeviceBuffer<double>::Upload(memory, kPurpose, knots, stream), buffers.knots);
  keep(DeviceBuffer<TensorPatch>::Upload(memory, kPurpose, patches, stream), buffers.patches);
  keep(DeviceBuffer<NetTables>::Upload(memory, kPurpose, tables, stream), buffers.tables);
  keep(DeviceBuffer<NetPoint>::Create(memory, kPurpose, points, stream), buffers.nets);
  status.Update((*lane)->stream().Synchronize("the comparator's tables"));
  if (!status.ok()) return status;
  return std::unique_ptr<BezierNetMaker>(
      new BezierNetMaker(std::move(plan), *std::move(lane), *std::move(frame), std::move(buffers)));
}

absl::Status BezierNetMaker::Enqueue(std::span<const Vec3d> control_points) {
  if (auto s = frame_.Upload(control_points); !s.ok()) return s;
  NetJob job{.patches = buffers_.patches.data(),
             .count = buffers_.patches.size(),
             .volume = {.control_points = frame_.control_points().data},
             .tables = buffers_.tables.data(),
             .nets = buffers_.nets.data()};
  const double* knots = buffers_.knots.data();
  for (size_t a = 0; a < 3; ++a) {
    job.volume.degree[a] = plan_->structure.degree[a];
    job.volume.size[a] = plan_->structure.size[a];
    job.volume.knots[a] = knots;
    knots += plan_->structure.knots[a].size();
  }
  const int m = BernsteinCount(plan_->structure.patch_degree());
  return CudaStatus(LaunchBezierNets(job, m, lane_->stream().get()), "the control nets");
}

absl::StatusOr<std::vector<NetPoint>> BezierNetMaker::Download() const {
  std::vector<NetPoint> nets(buffers_.nets.size());
  if (auto s =
          CudaStatus(cudaMemcpyAsync(nets.data(), buffers_.nets.data(), buffers_.nets.size_bytes(),
                                     cudaMemcpyDeviceToHost, lane_->stream().get()),
                     "the control nets");
      !s.ok()) {
    return s;
  }
  if (auto s = lane_->stream().Synchronize("the control nets"); !s.ok()) return s;
  return nets;
}

}  // namespace latticed::bench
