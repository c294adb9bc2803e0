// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/cuda_frame.h"

#include <cstring>
#include <utility>

namespace latticed {
namespace {

size_t ChunkListAt(const DeformPlan& plan) {
  const size_t bytes =
      static_cast<size_t>(plan.structure.control_point_count()) * sizeof(Vec3d) + plan.seams.size();
  return (bytes + sizeof(uint32_t) - 1) / sizeof(uint32_t) * sizeof(uint32_t);
}

size_t BytesOf(const DeformPlan& plan) {
  return ChunkListAt(plan) + plan.chunk_count() * sizeof(uint32_t);
}

}  // namespace

size_t CudaFrame::DeviceBytesFor(const DeformPlan& plan) {
  return StagedUpload::DeviceBytesFor(BytesOf(plan));
}

absl::StatusOr<CudaFrame> CudaFrame::Create(std::shared_ptr<const DeformPlan> plan,
                                            CudaContext& context, std::shared_ptr<CudaLane> lane) {
  auto room = DeviceReservation::Create(context.memory(), "an evaluation", DeviceBytesFor(*plan));
  if (!room.ok()) return room.status();
  return Create(std::move(plan), context, std::move(lane), *room);
}

absl::StatusOr<CudaFrame> CudaFrame::Create(std::shared_ptr<const DeformPlan> plan,
                                            CudaContext& context, std::shared_ptr<CudaLane> lane,
                                            DeviceReservation& from) {
  auto upload = StagedUpload::Create(context, std::move(lane), BytesOf(*plan), from);
  if (!upload.ok()) return upload.status();
  return CudaFrame(std::move(plan), *std::move(upload));
}

size_t CudaFrame::ChunksAt() const { return ChunkListAt(*plan_); }

absl::Status CudaFrame::Stage(std::span<const Vec3d> control_points,
                              std::span<const uint32_t> chunks) {
  const auto begin = upload_.Begin();
  if (!begin.ok()) return begin.status();
  const std::vector<bool> attached = AttachedSeams(*plan_, control_points);
  uint8_t* to = *begin;
  for (const Vec3d& p : control_points) {
    const Vec3d relative = p - plan_->local_origin;
    std::memcpy(to, &relative, sizeof(relative));
    to += sizeof(relative);
  }
  for (const bool seam : attached) *to++ = seam ? 1 : 0;
  all_chunks_ = chunks.size() == plan_->chunk_count();
  if (!all_chunks_) {
    to = *begin + ChunksAt();
    std::memcpy(to, chunks.data(), chunks.size_bytes());
    to += chunks.size_bytes();
  }
  bytes_ = static_cast<size_t>(to - *begin);
  return absl::OkStatus();
}

absl::Status CudaFrame::Upload(std::span<const Vec3d> control_points) {
  absl::Status sent = Stage(control_points, {});
  if (sent.ok()) sent = Send();
  sent.Update(Sent());
  return sent;
}

DeviceSpan<const Vec3d> CudaFrame::control_points() const {
  return {reinterpret_cast<const Vec3d*>(upload_.device_data()), points()};
}

DeviceSpan<const uint8_t> CudaFrame::attached() const {
  return {upload_.device_data() + points() * sizeof(Vec3d), plan_->seams.size()};
}

}  // namespace latticed
