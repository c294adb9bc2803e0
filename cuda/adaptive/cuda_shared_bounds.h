// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bounds that a slice on this device exchanges with slices on others (core/view/spanned/tolerance_slice.h), for the
// edges that they share.
//
//   device   edge maxima -> bounds of shared edges        host, pinned   from the device | to the device
//
// Errors   those of device_buffer.h, pinned_memory.h and cuda_status.h
// Threads  one at a time; Take and Raise enqueue, Wait waits for the last Take
#ifndef LATTICED_CUDA_ADAPTIVE_CUDA_SHARED_BOUNDS_H_
#define LATTICED_CUDA_ADAPTIVE_CUDA_SHARED_BOUNDS_H_

#include <cstdint>
#include <memory>
#include <span>

#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/device/pinned_memory.h"

namespace latticed {

class CudaSharedBounds {
 public:
  // edges: of the slice's plan; at least one. edge_maxima: of AdaptiveState. Works on the stream of `lane`.
  [[nodiscard]] static absl::StatusOr<CudaSharedBounds> Create(std::span<const uint32_t> edges,
                                                               uint32_t* edge_maxima,
                                                               CudaContext& context,
                                                               std::shared_ptr<CudaLane> lane);

  // Copies the maxima of the shared edges to the host.
  [[nodiscard]] absl::Status Take();
  // Valid until the next Take.
  [[nodiscard]] absl::StatusOr<std::span<const float>> Wait() const;
  // Sets these maxima. Not before the device has run the last Raise.
  [[nodiscard]] absl::Status Raise(std::span<const float> bounds);

  size_t DeviceBytes() const { return edges_.size_bytes() + bounds_.size_bytes(); }
  size_t PinnedBytes() const { return pinned_.size(); }

 private:
  CudaSharedBounds(uint32_t* edge_maxima, std::shared_ptr<CudaLane> lane,
                   DeviceBuffer<uint32_t> edges, DeviceBuffer<float> bounds, PinnedBuffer pinned,
                   CudaEvent taken);
  kernels::SharedMaxima Launch() const;
  float* taken_bounds() const { return reinterpret_cast<float*>(pinned_.data()); }
  float* raised_bounds() const { return taken_bounds() + edges_.size(); }

  uint32_t* edge_maxima_;
  std::shared_ptr<CudaLane> lane_;
  DeviceBuffer<uint32_t> edges_;
  DeviceBuffer<float> bounds_;
  PinnedBuffer pinned_;
  CudaEvent taken_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_CUDA_SHARED_BOUNDS_H_
