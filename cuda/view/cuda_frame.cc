// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/cuda_frame.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/status_macros.h"

namespace latticed {
namespace {

static_assert(LatticePart::kPagePoints * sizeof(Vec3d) == kernels::kUploadPage &&
              LatticePart::kMostPages <= kernels::kMostUploadPages);

size_t RoundUp(size_t bytes, size_t unit) { return (bytes + unit - 1) / unit * unit; }

size_t SeamsOf(const DeformPlan& plan) {
  const auto points = plan.control_point_count();
  return RoundUp(points * sizeof(Vec3d), kernels::kUploadUnit);
}

size_t ChunksOf(const DeformPlan& plan) {
  return RoundUp(SeamsOf(plan) + plan.seams.size(), sizeof(uint32_t));
}

size_t BytesOf(const DeformPlan& plan, bool has_chunk_needs) {
  const size_t boxes = has_chunk_needs ? LatticePart::MostBoxes(plan) : 0;
  return ChunksOf(plan) + (plan.chunk_count() + boxes) * sizeof(uint32_t);
}

uint8_t* Append(std::span<const uint32_t> list, uint8_t* to) {
  std::memcpy(to, list.data(), list.size_bytes());
  return to + list.size_bytes();
}

}  // namespace

size_t CudaFrame::DeviceBytesFor(const DeformPlan& plan, bool has_chunk_needs) {
  return StagedUpload::DeviceBytesFor(BytesOf(plan, has_chunk_needs));
}

size_t CudaFrame::PinnedBytesFor(const DeformPlan& plan, bool has_chunk_needs) {
  return StagedUpload::PinnedBytesFor(BytesOf(plan, has_chunk_needs));
}

absl::StatusOr<CudaFrame> CudaFrame::Create(std::shared_ptr<const DeformPlan> plan,
                                            std::shared_ptr<const ChunkNeeds> chunk_needs,
                                            CudaContext& context, std::shared_ptr<CudaLane> lane,
                                            DeviceReservation& from) {
  std::optional<LatticePart> part;
  if (chunk_needs != nullptr) part.emplace(plan, std::move(chunk_needs));
  LATTICED_ASSIGN_OR_RETURN(
      auto upload,
      StagedUpload::Create(context, std::move(lane), BytesOf(*plan, part.has_value()), from));
  return CudaFrame(std::move(plan), std::move(part), std::move(upload));
}

size_t CudaFrame::SeamsAt() const { return SeamsOf(*plan_); }
size_t CudaFrame::ChunksAt() const { return ChunksOf(*plan_); }

void CudaFrame::StagePoints(std::span<const Vec3d> control_points, size_t first, size_t last,
                            uint8_t* staged) const {
  uint8_t* to = staged + first * sizeof(Vec3d);
  for (const Vec3d& p : control_points.subspan(first, last - first)) {
    const Vec3d relative = p - plan_->local_origin;
    std::memcpy(to, &relative, sizeof(relative));
    to += sizeof(relative);
  }
}

void CudaFrame::StageSeams(std::span<const Vec3d> control_points, uint8_t* staged) const {
  const auto stage = [&](uint32_t seam) {
    staged[seam] = IsAttached(*plan_, plan_->seams[seam], control_points) ? 1 : 0;
  };
  if (only_part_) {
    for (const uint32_t seam : part_->seams()) stage(seam);
  } else {
    for (uint32_t seam = 0; seam < plan_->seams.size(); ++seam) stage(seam);
  }
}

absl::Status CudaFrame::Stage(std::span<const Vec3d> control_points,
                              std::span<const uint32_t> chunks) {
  LATTICED_ASSIGN_OR_RETURN(const auto begin, upload_.Begin());
  all_chunks_ = chunks.size() == plan_->chunk_count();
  only_part_ = part_.has_value() && !all_chunks_ && !chunks.empty() && part_->Select(chunks);
  if (only_part_) {
    for (const size_t page : part_->pages()) {
      const size_t first = page * LatticePart::kPagePoints;
      StagePoints(control_points, first, std::min(first + LatticePart::kPagePoints, points()),
                  begin);
    }
  } else {
    StagePoints(control_points, 0, points(), begin);
  }
  StageSeams(control_points, begin + SeamsAt());
  uint8_t* to = begin + SeamsAt() + plan_->seams.size();
  if (!all_chunks_) to = Append(chunks, begin + ChunksAt());
  boxes_at_ = static_cast<size_t>(to - begin);
  if (only_part_) to = Append(part_->boxes(), to);
  bytes_ = static_cast<size_t>(to - begin);
  return absl::OkStatus();
}

absl::Status CudaFrame::Upload(std::span<const Vec3d> control_points) {
  absl::Status sent = Stage(control_points, {});
  if (sent.ok()) sent = Send();
  sent.Update(Sent());
  return sent;
}

kernels::KernelCall CudaFrame::SendCall() const {
  if (!only_part_) return upload_.SendCall(bytes_);
  return upload_.SendCall(
      kernels::PagedUpload{.pages = part_->pages(), .paged_bytes = SeamsAt(), .bytes = bytes_});
}

DeviceSpan<const Vec3d> CudaFrame::control_points() const {
  return {reinterpret_cast<const Vec3d*>(upload_.device_data()), points()};
}

DeviceSpan<const uint8_t> CudaFrame::attached() const {
  return {upload_.device_data() + SeamsAt(), plan_->seams.size()};
}

DeviceSpan<const uint32_t> CudaFrame::boxes() const {
  if (!only_part_) return {nullptr, 0};
  return {ListAt(boxes_at_), part_->boxes().size()};
}

}  // namespace latticed
