// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sorted points in device memory, as kernels read them: 28 bytes a point, 52 with normals, and small tables of pieces and
// boxes.
//
// Errors   those of device_buffer.h
// Threads  immutable; usable on every stream once it is made. Work on it must be complete before it is destroyed.
#ifndef LATTICED_CUDA_POINTS_DEVICE_POINTS_H_
#define LATTICED_CUDA_POINTS_DEVICE_POINTS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/points/sorted_points.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/points/point_kernels.h"

namespace latticed {

class DevicePoints {
 public:
  // Uploads on the context's stream, and waits for it.
  [[nodiscard]] static absl::StatusOr<DevicePoints> Create(const SortedPoints& points,
                                                           CudaContext& context);

  const kernels::PointTables& tables() const { return tables_; }
  // The numbers of the boxes that have points, by slot.
  const std::vector<uint32_t>& boxes() const { return boxes_; }
  uint64_t bytes() const { return bytes_; }

 private:
  DevicePoints() = default;
  // By place.
  std::array<DeviceBuffer<double>, 6> coordinates_;  // of the world, then of normals
  DeviceBuffer<uint32_t> order_;
  DeviceBuffer<uint8_t> small_;
  kernels::PointTables tables_{};
  std::vector<uint32_t> boxes_;
  uint64_t bytes_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_POINTS_DEVICE_POINTS_H_
