// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/device_lattice.h"

#include <utility>
#include <vector>

#include "core/base/status_macros.h"

namespace latticed::bench {

DeviceLattice::DeviceLattice(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaLane> lane,
                             CudaFrame frame, DeviceBuffer<double> knots)
    : plan_(std::move(plan)),
      lane_(std::move(lane)),
      frame_(std::move(frame)),
      knots_(std::move(knots)) {}

absl::StatusOr<DeviceLattice> DeviceLattice::Create(std::shared_ptr<const DeformPlan> plan,
                                                    CudaContext& context) {
  LATTICED_ASSIGN_OR_RETURN(auto lane, context.lanes().Borrow());
  LATTICED_ASSIGN_OR_RETURN(auto room,
                            DeviceReservation::Create(context.memory(), "comparator",
                                                      CudaFrame::DeviceBytesFor(*plan, false)));
  LATTICED_ASSIGN_OR_RETURN(auto frame, CudaFrame::Create(plan, nullptr, context, lane, room));
  std::vector<double> knots;
  for (const auto& axis : plan->structure.knots) {
    knots.insert(knots.end(), axis.begin(), axis.end());
  }
  const CudaStream& stream = lane->stream();
  LATTICED_ASSIGN_OR_RETURN(
      auto uploaded,
      DeviceBuffer<double>::Upload(context.memory(), "comparator", knots, stream.get()));
  LATTICED_RETURN_IF_ERROR(stream.Synchronize("the comparator's knots"));
  return DeviceLattice(std::move(plan), std::move(lane), std::move(frame), std::move(uploaded));
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
