// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_device.h"

#include <algorithm>
#include <string_view>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "fmt/format.h"

namespace latticed {

DeviceGuard::DeviceGuard(int device) : device_(device) {
  static_cast<void>(cudaGetDevice(&previous_));
  if (previous_ != device_) static_cast<void>(cudaSetDevice(device_));
}

DeviceGuard::~DeviceGuard() {
  if (previous_ >= 0 && previous_ != device_) static_cast<void>(cudaSetDevice(previous_));
}

absl::StatusOr<CudaStream> CudaStream::Create(StreamPriority priority) {
  constexpr std::string_view kWhat = "a stream";
  int least = 0, greatest = 0;
  LATTICED_RETURN_IF_ERROR(CudaStatus(cudaDeviceGetStreamPriorityRange(&least, &greatest), kWhat));
  cudaStream_t stream = nullptr;
  // Lower numbers are greater priorities.
  const int number = priority == StreamPriority::kGreatest ? greatest
                     : priority == StreamPriority::kMiddle ? std::max(greatest, least - 1)
                                                           : least;
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaStreamCreateWithPriority(&stream, cudaStreamNonBlocking, number), kWhat));
  return CudaStream(stream);
}

absl::Status CudaStream::Synchronize(std::string_view what) const {
  return CudaStatus(cudaStreamSynchronize(get()), what);
}

absl::StatusOr<CudaEvent> CudaEvent::Create() {
  cudaEvent_t event = nullptr;
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "an event"));
  return CudaEvent(event);
}

absl::Status CudaEvent::Record(cudaStream_t stream) const {
  return CudaStatus(cudaEventRecord(event_.get(), stream), "an event");
}

absl::Status CudaEvent::HoldBack(cudaStream_t stream) const {
  return CudaStatus(cudaStreamWaitEvent(stream, event_.get(), cudaEventWaitDefault), "an event");
}

absl::Status CudaEvent::Synchronize() const {
  return CudaStatus(cudaEventSynchronize(event_.get()), "an event");
}

absl::Status CheckDevice(int device) {
  int count = 0;
  LATTICED_RETURN_IF_ERROR(CudaStatus(cudaGetDeviceCount(&count), "no CUDA device"));
  if (device < 0 || device >= count) {
    return error::Unavailable(
        "NO_DEVICE",
        fmt::format("no CUDA device {}: this machine has {}, counted from 0", device, count), 0);
  }
  int pools = 0;
  LATTICED_RETURN_IF_ERROR(CudaStatus(
      cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, device), "the device"));
  if (pools == 0) {
    return error::Unavailable("NO_DEVICE",
                              fmt::format("CUDA device {} has no memory pools", device), 0);
  }
  return absl::OkStatus();
}

absl::StatusOr<int> CountMultiprocessors(int device) {
  int count = 0;
  const cudaError_t failure =
      cudaDeviceGetAttribute(&count, cudaDevAttrMultiProcessorCount, device);
  LATTICED_RETURN_IF_ERROR(CudaStatus(failure, "the device"));
  return count;
}

int DriverVersion() {
  int version = 0;
  return cudaDriverGetVersion(&version) == cudaSuccess ? version : 0;
}

std::string DescribeDevice(int device) {
  cudaDeviceProp properties{};
  if (cudaGetDeviceProperties(&properties, device) != cudaSuccess) return "unknown device";
  return fmt::format("{}, {} multiprocessors, {:.0f} GiB", properties.name,
                     properties.multiProcessorCount,
                     static_cast<double>(properties.totalGlobalMem) / (uint64_t{1} << 30));
}

}  // namespace latticed
