// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Control points by formula (6) of all patches of a plan on the CUDA device (bezier_net.h).
//
// Errors   kResourceExhausted; those of the device
// Threads  one; Enqueue puts a copy of the control points and a kernel on the lane, nothing waits
#ifndef LATTICED_TESTS_BENCH_BEZIER_NET_MAKER_H_
#define LATTICED_TESTS_BENCH_BEZIER_NET_MAKER_H_

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/cuda_context.h"
#include "cuda/view/cuda_frame.h"
#include "tests/bench/bezier_net.h"

namespace latticed::bench {

class BezierNetMaker {
 public:
  // On a lane of its own.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<BezierNetMaker>> Create(
      std::shared_ptr<const DeformPlan> plan, CudaContext& context);

  [[nodiscard]] absl::Status Enqueue(std::span<const Vec3d> control_points);
  // What the last Enqueue made; waits for it.
  [[nodiscard]] absl::StatusOr<std::vector<NetPoint>> Download() const;
  const CudaLane& lane() const { return *lane_; }

 private:
  struct Buffers {
    DeviceBuffer<double> knots;  // of u, then v, then w
    DeviceBuffer<TensorPatch> patches;
    DeviceBuffer<NetTables> tables;
    DeviceBuffer<NetPoint> nets;
  };

  BezierNetMaker(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<CudaLane> lane,
                 CudaFrame frame, Buffers buffers);

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<CudaLane> lane_;
  CudaFrame frame_;
  Buffers buffers_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_BEZIER_NET_MAKER_H_
