// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CUDA device as benchmarks see it: its backend, its ceilings, and clocks for what a view
// enqueues. A build without CUDA compiles gpu_stub.cc instead of gpu_cuda.cc and has no device.
//
// Times    medians and least of the runs, milliseconds, each run after the L2 cache was written
//          full of something else. The stream waits at a gate until all of a run's work is on it,
//          so that no time of the host is in them, but for LaunchToResult and WallTime, which are of
//          the host. WallTime flushes no cache.
// Errors   of the device end the program: a benchmark without its device means nothing
// Threads  one
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_H_

#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"

namespace latticed::bench {

// Per second, measured.
struct GpuFloors {
  double written = 0;        // bytes, write only
  double copied = 0;         // bytes read plus bytes written, device to device
  double to_device = 0;      // bytes, pinned
  double to_host = 0;        // bytes, pinned
  double multiply_adds = 0;  // float32
};

struct GpuTimes {
  double median = 0, least = 0;
};
[[nodiscard]] inline GpuTimes MedianAndLeast(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values.front()};
}

// Of one evaluation. `copy` brings the control points, `rest` is what follows the last named stage.
struct GpuStage {
  std::string name;
  double device_ms = 0;  // median
  double host_ms = 0;    // median: enqueueing it
};

// Of one evaluation on one device or several, by the host's clock.
struct WallTimes {
  GpuTimes whole;         // until the last device is done
  double enqueue_ms = 0;  // median: until Evaluate returns
};

// Of all patches, and what making them takes with the copy of the lattice's control points.
struct BezierNets {
  std::vector<NetPoint> nets;  // of the first set of control points
  GpuTimes times;
};

// The tensor-product comparator: its stages "copy", "control points" and "rest", the tessellation;
// and all of it.
struct TensorTimes {
  std::vector<GpuStage> stages;
  GpuTimes whole;
};
// Asked once, before anything is timed, about the vertices of the first set of control points.
using TensorCheck = std::function<absl::Status(std::span<const TensorVertex> vertices)>;

// Evaluates the view that is timed, once; `run` counts.
using GpuWork = std::function<absl::Status(int run)>;

class Gpu {
 public:
  virtual ~Gpu() = default;
  virtual Backend& backend() = 0;
  virtual const GpuFloors& floors() = 0;  // measured on the first call, in less than a second
  // The surfaces of a plan from two sets of the lattice's control points by turns. The errors are
  // those of `check`.
  virtual absl::StatusOr<TensorTimes> TensorProduct(
      const std::shared_ptr<const DeformPlan>& plan, const TensorSurfaces& surfaces,
      std::span<const std::vector<Vec3d>, 2> control_points, const TensorCheck& check,
      int runs) = 0;
  // Control points by formula (6), from two sets of the lattice's by turns.
  virtual BezierNets ControlNets(const std::shared_ptr<const DeformPlan>& plan,
                                 std::span<const std::vector<Vec3d>, 2> control_points,
                                 int runs) = 0;

  // Events around one Evaluate of the view.
  virtual GpuTimes DeviceTime(DeformView& view, const GpuWork& work, int runs) = 0;
  // The host's clock, from the call of Evaluate until its results are in device memory.
  virtual GpuTimes LaunchToResult(DeformView& view, const GpuWork& work, int runs) = 0;
  // How many devices this machine has, and a backend on the first `count` of them, all of whose
  // plans span where there are two or more.
  virtual int device_count() const = 0;
  virtual std::unique_ptr<Backend> OnDevices(int count) = 0;
  // Of a view of such a backend.
  virtual WallTimes WallTime(DeformView& view, const GpuWork& work, int runs) = 0;
  // Events between the stages too, in order; a stage that returns is added up.
  virtual std::vector<GpuStage> Stages(DeformView& view, const GpuWork& work, int runs) = 0;
  // Formula (24) for patches of degree n, in double, as (18) is.
  virtual GpuTimes Formula24(int n, int segments, int runs) = 0;
};

// Made on the first call, for device 0. kUnimplemented in a build without CUDA, kUnavailable
// without a device.
[[nodiscard]] absl::StatusOr<Gpu*> TheGpu();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_H_
