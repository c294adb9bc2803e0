// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The device memory of a view with a tolerance, but its vertices: tables that depend on the plan, and the state of the
// last evaluation.
//
//   tables   edges 12 a patch | patterns, 0.6 MB in all
//   state    reach 12, slack 24 a box (36 with weights) | bounds 24, first point 2 a patch | scratch of the scan |
//            maxima 4 an edge | largest error | first points 8 a chunk | codes 2 a patch
//
// Each part begins at a multiple of 256 bytes. From the maxima to the largest error, zeros are written in one go; from
// the largest error to the codes, results are copied to the host in one go.
//
// Errors   those of device_buffer.h and of cuda_status.h
// Threads  one at a time; calls enqueue on the stream of Create and do not wait
#ifndef LATTICED_CUDA_ADAPTIVE_ADAPTIVE_MEMORY_H_
#define LATTICED_CUDA_ADAPTIVE_ADAPTIVE_MEMORY_H_

#include <cstring>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/adaptive/adaptive_kernels.h"
#include "cuda/device/device_buffer.h"

namespace latticed {

// By patch, three: Patch::edge.
[[nodiscard]] std::vector<uint32_t> PatchEdges(const DeformPlan& plan);

// What an evaluation copies to the host: reads a copy of AdaptiveMemory::results.
class AdaptiveResults {
 public:
  AdaptiveResults(const DeformPlan& plan, const uint8_t* bytes);

  float largest_error() const;
  // chunk_count + 1 numbers.
  std::span<const uint64_t> chunk_first() const { return chunk_first_; }
  // kPatchesPerChunk for each chunk; zeros past the last patch.
  std::span<const uint16_t> codes() const { return codes_; }

 private:
  const uint8_t* bytes_;
  std::span<const uint64_t> chunk_first_;
  std::span<const uint16_t> codes_;
};

class AdaptiveMemory {
 public:
  // Takes BytesFor from the reservation.
  [[nodiscard]] static absl::StatusOr<AdaptiveMemory> Create(const DeformPlan& plan,
                                                             DeviceReservation& from,
                                                             cudaStream_t stream);
  static absl::StatusOr<uint64_t> BytesFor(const DeformPlan& plan);

  const kernels::AdaptiveTables& tables() const { return tables_; }
  kernels::AdaptiveState state() const;
  DeviceSpan<uint8_t> scan_scratch() const;
  // Pads included.
  DeviceSpan<const uint8_t> results() const;
  // Sets the edges' maxima and the largest error to zero, or the latter alone.
  [[nodiscard]] absl::Status ClearMaxima() const;
  [[nodiscard]] absl::Status ClearError() const;

  size_t size_bytes() const { return block_.size_bytes() + table_block_.size_bytes(); }

 private:
  // Offsets in block_.
  struct Parts {
    size_t reach, slack, edge_bounds, mixed_bounds, first_points, scan, edge_maxima, largest_error,
        chunk_first, codes, end;
  };
  static Parts PartsOf(const DeformPlan& plan, size_t scan_bytes);
  friend class AdaptiveResults;

  absl::Status Clear(size_t begin, size_t end) const;

  cudaStream_t stream_ = nullptr;
  Parts parts_{};
  DeviceBuffer<uint8_t> block_, table_block_;
  kernels::AdaptiveTables tables_{};
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_ADAPTIVE_MEMORY_H_
