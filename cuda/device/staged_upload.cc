// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/staged_upload.h"

#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"

namespace latticed {

size_t StagedUpload::DeviceBytesFor(size_t bytes) {
  return (bytes + kernels::kUploadUnit - 1) / kernels::kUploadUnit * kernels::kUploadUnit;
}

absl::StatusOr<StagedUpload> StagedUpload::Create(CudaContext& context,
                                                  std::shared_ptr<CudaLane> lane, size_t bytes,
                                                  DeviceReservation& from) {
  bytes = DeviceBytesFor(bytes);
  LATTICED_ASSIGN_OR_RETURN(
      auto device, DeviceBuffer<uint8_t>::Create(from, "staging", bytes, lane->stream().get()));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context.pinned().Borrow(bytes));
  LATTICED_ASSIGN_OR_RETURN(auto copied, CudaEvent::Create());
  return StagedUpload(std::move(lane), std::move(device), std::move(pinned), std::move(copied));
}

StagedUpload::~StagedUpload() {
  // The copy must be complete before the pinned bytes go back for reuse.
  if (lane_ != nullptr) static_cast<void>(copied_.Synchronize());
}

absl::StatusOr<uint8_t*> StagedUpload::Begin() {
  LATTICED_RETURN_IF_ERROR(copied_.Synchronize());
  return pinned_.data();
}

kernels::KernelCall StagedUpload::SendCall(size_t bytes) const {
  return kernels::UploadCall(pinned_.data(), bytes, device_.data());
}

kernels::KernelCall StagedUpload::SendCall(const kernels::PagedUpload& upload) const {
  return kernels::UploadCall(pinned_.data(), upload, device_.data());
}

absl::Status StagedUpload::Send(kernels::KernelCall call) const {
  return CudaStatus(call.Launch(lane_->stream().get()), "the copy of an edit");
}

absl::Status StagedUpload::Sent() const { return copied_.Record(lane_->stream().get()); }

}  // namespace latticed
