// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Control points by formula (6) of all patches of a plan on the CUDA device (bezier_net.h).
//
// Errors   kResourceExhausted; those of the device
// Threads  one; Enqueue puts a copy of the control points and a kernel on the lane, nothing waits
#ifndef LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_MAKER_H_
#define LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_MAKER_H_

#include <memory>
#include <span>
#include <vector>

#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/device_lattice.h"

namespace latticed::bench {

class BezierNetMaker {
 public:
  // On a lane of its own.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<BezierNetMaker>> Create(
      const std::shared_ptr<const DeformPlan>& plan, CudaContext& context);

  [[nodiscard]] absl::Status Enqueue(std::span<const Vec3d> control_points);
  // What the last Enqueue made; waits for it.
  [[nodiscard]] absl::StatusOr<std::vector<NetPoint>> Download() const;
  CudaLane& lane() const { return lattice_.lane(); }

 private:
  struct Buffers {
    DeviceBuffer<NetPatch> patches;
    DeviceBuffer<NetTables> tables;
    DeviceBuffer<NetPoint> nets;
  };

  BezierNetMaker(int m, DeviceLattice lattice, Buffers buffers);

  int m_;
  DeviceLattice lattice_;
  Buffers buffers_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_MAKER_H_
