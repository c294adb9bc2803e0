// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies chunks of a view to pinned host memory in batches. While the caller uses one batch, the
// next one is copied.
//
//   for each batch k:  Wait(k's copy)   Copy(k + 1)   use k        two buffers alternate
//
// Errors   those of pinned_memory.h, device_buffer.h and cuda_status.h
// Threads  one at a time
#ifndef LATTICED_CUDA_VIEW_DEVICE_STAGING_H_
#define LATTICED_CUDA_VIEW_DEVICE_STAGING_H_

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/view/vertex_layout.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/pinned_memory.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

class DeviceStaging {
 public:
  // Receives the named chunks first … first + bytes.size() - 1, each in wire layout. The bytes are
  // valid during the call.
  using UseBatch = absl::FunctionRef<absl::Status(size_t first,
                                                  std::span<const std::span<const uint8_t>> bytes)>;

  // Copies from the vertices that `kernel` filled, on the stream of `lane`.
  DeviceStaging(VertexLayout layout, std::shared_ptr<CudaContext> context,
                std::shared_ptr<CudaLane> lane)
      : layout_(layout), context_(std::move(context)), lane_(std::move(lane)) {}

  // Calls `use` for all of `chunks`, in order. All copies are complete when it returns.
  [[nodiscard]] absl::Status Fetch(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                   std::span<const uint32_t> chunks, UseBatch use);

  size_t DeviceBytes() const;
  size_t PinnedBytes() const;

 private:
  struct Slot {
    PinnedBuffer pinned;
    DeviceBuffer<uint8_t> wire;  // only for kernels with their own order
    std::optional<CudaEvent> copied;
  };
  struct Batch {
    size_t first = 0;
    std::vector<std::span<const uint8_t>> bytes;
  };

  absl::Status Run(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                   std::span<const uint32_t> chunks, UseBatch use);
  size_t BatchEnd(std::span<const uint32_t> chunks, size_t first) const;
  absl::Status Reserve(Slot& slot, size_t bytes, bool own_order);
  absl::Status Copy(Slot& slot, CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                    std::span<const uint32_t> chunks, Batch& batch);

  VertexLayout layout_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  std::array<Slot, 2> slots_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_DEVICE_STAGING_H_
