// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The current device of the calling thread, and the streams and events of a device.
//
// Errors   those of cuda_status.h; destructors ignore errors, also while the runtime unloads
// Threads  a DeviceGuard belongs to its thread; several threads may enqueue on a stream, which runs
//          the work in the order of the calls; an event is used by one thread at a time
#ifndef LATTICED_CUDA_DEVICE_CUDA_DEVICE_H_
#define LATTICED_CUDA_DEVICE_CUDA_DEVICE_H_

#include <cuda_runtime_api.h>

#include <memory>
#include <string>
#include <type_traits>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

// Makes a device current. The destructor restores the previous one.
class DeviceGuard {
 public:
  explicit DeviceGuard(int device);
  ~DeviceGuard();
  DeviceGuard(const DeviceGuard&) = delete;  // restores once
  DeviceGuard& operator=(const DeviceGuard&) = delete;

 private:
  int device_;
  int previous_ = -1;
};

// When blocks of several streams wait for a multiprocessor, those of greater priority start first.
enum class StreamPriority { kLeast, kMiddle, kGreatest };

// A stream that does not wait for the legacy default stream.
class CudaStream {
 public:
  // On the current device.
  [[nodiscard]] static absl::StatusOr<CudaStream> Create(
      StreamPriority priority = StreamPriority::kLeast);

  cudaStream_t get() const { return stream_.get(); }
  // Waits for this stream alone.
  [[nodiscard]] absl::Status Synchronize(std::string_view what) const;

 private:
  struct Destroy {
    void operator()(cudaStream_t stream) const { static_cast<void>(cudaStreamDestroy(stream)); }
  };

  explicit CudaStream(cudaStream_t stream) : stream_(stream) {}
  std::unique_ptr<std::remove_pointer_t<cudaStream_t>, Destroy> stream_;
};

// Orders work. Records no time.
class CudaEvent {
 public:
  [[nodiscard]] static absl::StatusOr<CudaEvent> Create();

  // Marks the end of the work that is now on the stream. Does not wait.
  [[nodiscard]] absl::Status Record(cudaStream_t stream) const;
  // What is enqueued on the stream from now on waits for the last mark. Does not wait itself.
  [[nodiscard]] absl::Status HoldBack(cudaStream_t stream) const;
  // Waits for the last mark. Returns at once where there is none.
  [[nodiscard]] absl::Status Synchronize() const;

 private:
  struct Destroy {
    void operator()(cudaEvent_t event) const { static_cast<void>(cudaEventDestroy(event)); }
  };

  explicit CudaEvent(cudaEvent_t event) : event_(event) {}
  std::unique_ptr<std::remove_pointer_t<cudaEvent_t>, Destroy> event_;
};

// kUnavailable where this machine has no such device, or no driver for it.
[[nodiscard]] absl::Status CheckDevice(int device);
[[nodiscard]] absl::StatusOr<int> CountMultiprocessors(int device);
// "NVIDIA H200, 132 multiprocessors, 140 GiB".
[[nodiscard]] std::string DescribeDevice(int device);
// The newest CUDA that it supports: 13000. 0: unknown
[[nodiscard]] int DriverVersion();

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_CUDA_DEVICE_H_
