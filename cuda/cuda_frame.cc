// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_frame.h"

#include <cstring>
#include <utility>

namespace latticed {

absl::StatusOr<CudaFrame> CudaFrame::Create(std::shared_ptr<const DeformPlan> plan,
                                            CudaContext& context, std::shared_ptr<CudaLane> lane) {
  const size_t bytes = static_cast<size_t>(plan->structure.control_point_count()) * sizeof(Vec3d) +
                       plan->seams.size();
  auto device =
      DeviceBuffer<uint8_t>::Create(context.memory(), "staging", bytes, lane->stream().get());
  if (!device.ok()) return device.status();
  auto pinned = context.pinned().Borrow(bytes);
  if (!pinned.ok()) return pinned.status();
  auto copied = CudaEvent::Create();
  if (!copied.ok()) return copied.status();
  return CudaFrame(std::move(plan), std::move(lane), *std::move(device), *std::move(pinned),
                   *std::move(copied));
}

CudaFrame::~CudaFrame() {
  // The pinned bytes go back to others: not before they are read.
  if (lane_ != nullptr) static_cast<void>(copied_.Synchronize());
}

absl::Status CudaFrame::Upload(std::span<const Vec3d> control_points) {
  if (auto s = copied_.Synchronize(); !s.ok()) return s;
  const std::vector<bool> attached = AttachedSeams(*plan_, control_points);
  uint8_t* to = pinned_.data();
  for (const Vec3d& p : control_points) {
    const Vec3d relative = p - plan_->local_origin;
    std::memcpy(to, &relative, sizeof(relative));
    to += sizeof(relative);
  }
  for (const bool seam : attached) *to++ = seam ? 1 : 0;
  if (auto s = CudaStatus(cudaMemcpyAsync(device_.data(), pinned_.data(), device_.size_bytes(),
                                          cudaMemcpyHostToDevice, lane_->stream().get()),
                          "the copy of control points");
      !s.ok()) {
    return s;
  }
  return copied_.Record(lane_->stream().get());
}

DeviceSpan<const Vec3d> CudaFrame::control_points() const {
  return {reinterpret_cast<const Vec3d*>(device_.data()), points()};
}

DeviceSpan<const uint8_t> CudaFrame::attached() const {
  return {device_.data() + points() * sizeof(Vec3d), plan_->seams.size()};
}

}  // namespace latticed
