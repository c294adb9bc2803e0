// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A few KB that change from one evaluation to the next, brought to the device by upload_kernel.cu
// from pinned memory of their own.
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
  // Copies on the stream of `lane`. Its memory on the device is of bytes reserved:
  // DeviceBytesFor(bytes).
  [[nodiscard]] static absl::StatusOr<StagedUpload> Create(CudaContext& context,
                                                           std::shared_ptr<CudaLane> lane,
                                                           size_t bytes, DeviceReservation& from);
  static size_t DeviceBytesFor(size_t bytes);
  ~StagedUpload();
  StagedUpload(StagedUpload&&) = default;
  StagedUpload& operator=(StagedUpload&&) = delete;

  // Where the next bytes are to be written: all of them.
  [[nodiscard]] absl::StatusOr<uint8_t*> Begin();
  // Sends the first `bytes` to the device. Call Sent at once, or when the kernels that read the
  // bytes are on the stream: nothing may come between the copy and a dependent launch.
  [[nodiscard]] absl::Status Send(size_t bytes) const { return Send(SendCall(bytes)); }
  [[nodiscard]] absl::Status Send(kernels::KernelCall call) const;
  kernels::KernelCall SendCall(size_t bytes) const;
  // Sends the named pages, and everything after all pages.
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
