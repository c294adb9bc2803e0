// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The device memory of a view of edge bounds, but its polynomials: tables that depend on the plan, and the state of the
// last evaluation.
//
//   tables   edges 12 a patch | first edges 4 a chunk
//   state    reach 12, slack 24 a box (36 with weights) | bounds 12 a patch | maxima 4 an edge | bytes 1 an edge
//
// Each part begins at a multiple of 256 bytes.
//
// Errors   those of device_buffer.h and of cuda_status.h
// Threads  one at a time; calls enqueue on the stream of Create and do not wait
#ifndef LATTICED_CUDA_BOUNDS_EDGE_BOUND_MEMORY_H_
#define LATTICED_CUDA_BOUNDS_EDGE_BOUND_MEMORY_H_

#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/device/device_buffer.h"

namespace latticed {

class EdgeBoundMemory {
 public:
  // Takes BytesFor from the reservation. All bounds and all bytes are 0.
  [[nodiscard]] static absl::StatusOr<EdgeBoundMemory> Create(const DeformPlan& plan,
                                                              std::vector<uint32_t> first_edges,
                                                              DeviceReservation& from,
                                                              cudaStream_t stream);
  static uint64_t BytesFor(const DeformPlan& plan);

  // Of the tables only `edges`, and of the state only what the bounds along edges need.
  kernels::AdaptiveTables tables() const;
  kernels::AdaptiveState state() const;
  const uint32_t* first_edges() const { return first_edges_; }
  uint8_t* bytes() const { return block_.data() + parts_.bytes; }
  [[nodiscard]] absl::Status ClearMaxima() const;

  size_t size_bytes() const { return block_.size_bytes() + table_block_.size_bytes(); }

 private:
  // Offsets in block_.
  struct Parts {
    size_t reach, slack, bounds, maxima, bytes, end;
  };
  static Parts PartsOf(const DeformPlan& plan);
  absl::Status Clear(size_t begin, size_t end) const;

  cudaStream_t stream_ = nullptr;
  Parts parts_{};
  DeviceBuffer<uint8_t> block_, table_block_;
  const uint32_t *edges_ = nullptr, *first_edges_ = nullptr;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_BOUNDS_EDGE_BOUND_MEMORY_H_
