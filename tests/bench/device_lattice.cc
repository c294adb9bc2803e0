// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/device_lattice.h"

#include <utility>
#include <vector>

namespace latticed::bench {

DeviceLattice::DeviceLattice(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaLane> lane,
                             CudaFrame frame, DeviceBuffer<double> knots)
    : plan_(std::move(plan)),
      lane_(std::move(lane)),
      frame_(std::move(frame)),
      knots_(std::move(knots)) {}

absl::StatusOr<DeviceLattice> DeviceLattice::Create(std::shared_ptr<const DeformPlan> plan,
                                                    CudaContext& context) {
  auto lane = context.lanes().Borrow();
  if (!lane.ok()) return lane.status();
  auto room = DeviceReservation::Create(context.memory(), "comparator",
                                        CudaFrame::DeviceBytesFor(*plan, false));
  if (!room.ok()) return room.status();
  auto frame = CudaFrame::Create(plan, nullptr, context, *lane, *room);
  if (!frame.ok()) return frame.status();
  std::vector<double> knots;
  for (const auto& axis : plan->structure.knots) {
    knots.insert(knots.end(), axis.begin(), axis.end());
  }
  const CudaStream& stream = (*lane)->stream();
  auto uploaded = DeviceBuffer<double>::Upload(context.memory(), "comparator", knots, stream.get());
  if (!uploaded.ok()) return uploaded.status();
  if (auto s = stream.Synchronize("the comparator's knots"); !s.ok()) return s;
  return DeviceLattice(std::move(plan), *std::move(lane), *std::move(frame), *std::move(uploaded));
}

VolumeView DeviceLattice::volume() const {
  VolumeView volume{.control_points = frame_.control_points().data};
  const double* knots = knots_.data();
  for (size_t a = 0; a < 3; ++a) {
    volume.degree[a] = plan_->structure.degree[a];
    volume.size[a] = plan_->structure.size[a];
    volume.knots[a] = knots;
    knots += plan_->structure.knots[a].size();
  }
  return volume;
}

}  // namespace latticed::bench
