// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The reach of boxes (AdaptiveState::reach), from the device to other slices of a plan and back: the functions of
// core/view/spanned/reach_slice.h.
//
// Errors   those of cuda_status.h
// Threads  one at a time; ReadReach waits, WriteReach has read its argument when it returns
#ifndef LATTICED_CUDA_ADAPTIVE_BOX_REACH_H_
#define LATTICED_CUDA_ADAPTIVE_BOX_REACH_H_

#include <span>
#include <vector>

#include "core/base/status_macros.h"
#include "core/base/vec.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/cuda_status.h"

namespace latticed {

// reach: [box][3]
[[nodiscard]] inline absl::StatusOr<std::vector<Vec3d>> ReadReach(const uint32_t* reach,
                                                                  size_t boxes,
                                                                  const CudaStream& stream) {
  std::vector<Vec3f> floats(boxes);
  LATTICED_RETURN_IF_ERROR(CudaStatus(cudaMemcpyAsync(floats.data(), reach, boxes * sizeof(Vec3f),
                                                      cudaMemcpyDeviceToHost, stream.get()),
                                      "the copy of reaches"));
  LATTICED_RETURN_IF_ERROR(stream.Synchronize("the copy of reaches"));
  std::vector<Vec3d> wide;
  wide.reserve(boxes);
  for (const Vec3f& r : floats) wide.push_back(ToDouble(r));
  return wide;
}

[[nodiscard]] inline absl::Status WriteReach(std::span<const Vec3d> from, uint32_t* reach,
                                             const CudaStream& stream) {
  std::vector<Vec3f> narrow;  // exact: they came from floats
  narrow.reserve(from.size());
  for (const Vec3d& r : from) narrow.push_back(ToFloat(r));
  return CudaStatus(cudaMemcpyAsync(reach, narrow.data(), narrow.size() * sizeof(Vec3f),
                                    cudaMemcpyHostToDevice, stream.get()),
                    "the copy of reaches");
}

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_BOX_REACH_H_
