// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Brings a few KB that change with each evaluation to the device. upload_kernel.cu copies them from
// a pinned buffer of this object.
//
// Errors   those of device_buffer.h and pinned_memory.h
// Threads  one at a time; Send and Sent enqueue, Begin waits for the last Sent
#ifndef LATTICED_CUDA_DEVICE_STAGED_UPLOAD_H_
#define LATTICED_CUDA_DEVICE_STAGED_UPLOAD_H_

#include <memory>
#include <span>

#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/device/upload_kernel.h"

namespace latticed {

class StagedUpload {
 public:
  // Copies on the stream of `lane`. Takes DeviceBytesFor(bytes) from the reservation.
  [[nodiscard]] static absl::StatusOr<StagedUpload> Create(CudaContext& context,
                                                           std::shared_ptr<CudaLane> lane,
                                                           size_t bytes, DeviceReservation& from);
  static size_t DeviceBytesFor(size_t bytes);
  static size_t PinnedBytesFor(size_t bytes) {
    return PinnedMemory::BlockBytes(DeviceBytesFor(bytes));
  }
  ~StagedUpload();
  StagedUpload(StagedUpload&&) = default;
  StagedUpload& operator=(StagedUpload&&) = delete;

  // Waits for the last copy. Returns where to write the next bytes; those of the last time are still there.
  [[nodiscard]] absl::StatusOr<uint8_t*> Begin();
  // Send copies the first `bytes` to the device. Sent must follow: at once, or after the launch of
  // the kernels that read the bytes, since a dependent launch must directly follow the copy.
  [[nodiscard]] absl::Status Send(size_t bytes) const { return Send(SendCall(bytes)); }
  [[nodiscard]] absl::Status Send(kernels::KernelCall call) const;
  kernels::KernelCall SendCall(size_t bytes) const;
  // Copies the named pages, and everything after the paged bytes.
  kernels::KernelCall SendCall(const kernels::PagedUpload& upload) const;
  [[nodiscard]] absl::Status Sent() const;

  const uint8_t* device_data() const { return device_.data(); }
  size_t DeviceBytes() const { return device_.size_bytes(); }
  size_t PinnedBytes() const { return pinned_.size(); }

 private:
  StagedUpload(std::shared_ptr<CudaLane> lane, DeviceBuffer<uint8_t> device, PinnedBuffer pinned,
               CudaEvent copied)
      : lane_(std::move(lane)),
        device_(std::move(device)),
        pinned_(std::move(pinned)),
        copied_(std::move(copied)) {}

  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint8_t> device_;
  PinnedBuffer pinned_;
  CudaEvent copied_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_STAGED_UPLOAD_H_
