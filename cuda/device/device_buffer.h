// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Owns elements in device memory. They are allocated and freed in the order of one stream.
//
// Create, Upload and the destructor enqueue on that stream and do not wait. Work of other streams
// on the buffer must be complete before the destructor runs.
//
// Errors   kResourceExhausted with asked and free bytes
// Threads  one at a time
#ifndef LATTICED_CUDA_DEVICE_DEVICE_BUFFER_H_
#define LATTICED_CUDA_DEVICE_DEVICE_BUFFER_H_

#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "cuda/device/device_memory.h"
#include "cuda/device/device_reservation.h"
#include "cuda/device/device_span.h"

namespace latticed {

template <typename T>
class DeviceBuffer {
  static_assert(std::is_trivially_copyable_v<T>, "copied byte by byte");

 public:
  DeviceBuffer() = default;
  // `purpose`: a literal, as in MemoryUse. The elements are not initialised.
  [[nodiscard]] static absl::StatusOr<DeviceBuffer> Create(std::shared_ptr<DeviceMemory> memory,
                                                           std::string_view purpose, size_t count,
                                                           cudaStream_t stream) {
    LATTICED_ASSIGN_OR_RETURN(const auto data,
                              memory->Allocate(purpose, count * sizeof(T), stream));
    return DeviceBuffer(std::move(memory), purpose, static_cast<T*>(data), count, stream);
  }
  // The same, from reserved bytes.
  [[nodiscard]] static absl::StatusOr<DeviceBuffer> Create(DeviceReservation& from,
                                                           std::string_view purpose, size_t count,
                                                           cudaStream_t stream) {
    LATTICED_ASSIGN_OR_RETURN(const auto data, from.Allocate(purpose, count * sizeof(T), stream));
    return DeviceBuffer(from.memory(), purpose, static_cast<T*>(data), count, stream);
  }
  // Copies elements of the host. Pinned elements must stay until the stream has passed the copy.
  // Pageable ones may be freed at once, because the runtime stages them.
  [[nodiscard]] static absl::StatusOr<DeviceBuffer> Upload(std::shared_ptr<DeviceMemory> memory,
                                                           std::string_view purpose,
                                                           std::span<const T> from,
                                                           cudaStream_t stream) {
    return Filled(Create(std::move(memory), purpose, from.size(), stream), from);
  }
  [[nodiscard]] static absl::StatusOr<DeviceBuffer> Upload(DeviceReservation& room,
                                                           std::string_view purpose,
                                                           std::span<const T> from,
                                                           cudaStream_t stream) {
    return Filled(Create(room, purpose, from.size(), stream), from);
  }
  T* data() const { return data_.get(); }
  size_t size() const { return size_; }
  size_t size_bytes() const { return size_ * sizeof(T); }
  DeviceSpan<T> span() const { return {data(), size_}; }

 private:
  struct Free {
    std::shared_ptr<DeviceMemory> memory;
    std::string_view purpose;
    size_t bytes = 0;
    cudaStream_t stream = nullptr;
    void operator()(T* data) const { memory->Free(data, purpose, bytes, stream); }
  };

  DeviceBuffer(std::shared_ptr<DeviceMemory> memory, std::string_view purpose, T* data, size_t size,
               cudaStream_t stream)
      : data_(data, Free{std::move(memory), purpose, size * sizeof(T), stream}), size_(size) {}

  static absl::StatusOr<DeviceBuffer> Filled(absl::StatusOr<DeviceBuffer> buffer,
                                             std::span<const T> from) {
    if (!buffer.ok() || from.empty()) return buffer;
    LATTICED_RETURN_IF_ERROR(
        CudaStatus(cudaMemcpyAsync(buffer->data(), from.data(), from.size_bytes(),
                                   cudaMemcpyHostToDevice, buffer->data_.get_deleter().stream),
                   buffer->data_.get_deleter().purpose));
    return buffer;
  }
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_BUFFER_H_
