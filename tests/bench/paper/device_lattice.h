// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What comparators on the CUDA device share: a lane of their own, the lattice there, and the way back.
//
// Errors   kResourceExhausted; those of the device
// Threads  one; Send puts a copy of the control points on the lane, and does not wait; Download does
#ifndef LATTICED_TESTS_BENCH_PAPER_DEVICE_LATTICE_H_
#define LATTICED_TESTS_BENCH_PAPER_DEVICE_LATTICE_H_

#include <memory>
#include <span>
#include <vector>

#include "core/ffd/volume_point.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/cuda_status.h"
#include "cuda/device/device_buffer.h"
#include "cuda/view/cuda_frame.h"

namespace latticed::bench {

class DeviceLattice {
 public:
  [[nodiscard]] static absl::StatusOr<DeviceLattice> Create(std::shared_ptr<const DeformPlan> plan,
                                                            CudaContext& context);

  [[nodiscard]] absl::Status Send(std::span<const Vec3d> control_points) {
    return frame_.Upload(control_points);
  }
  // Relative to the plan's local origin, as the control points are there.
  VolumeView volume() const;
  // What was put on the lane, once that is done; `what` is named in errors.
  template <class T>
  [[nodiscard]] absl::StatusOr<std::vector<T>> Download(const DeviceBuffer<T>& from,
                                                        const char* what) const {
    std::vector<T> to(from.size());
    absl::Status status = CudaStatus(cudaMemcpyAsync(to.data(), from.data(), from.size_bytes(),
                                                     cudaMemcpyDeviceToHost, stream()),
                                     what);
    if (status.ok()) status = lane_->stream().Synchronize(what);
    if (!status.ok()) return status;
    return to;
  }
  CudaLane& lane() const { return *lane_; }
  cudaStream_t stream() const { return lane_->stream().get(); }

 private:
  DeviceLattice(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaLane> lane,
                CudaFrame frame, DeviceBuffer<double> knots);

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<CudaLane> lane_;
  CudaFrame frame_;
  DeviceBuffer<double> knots_;  // of u, then v, then w
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_DEVICE_LATTICE_H_
