// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CUDA device as benchmarks see it: its backend, its measured limits, and clocks for what a view
// enqueues. A build without CUDA compiles gpu_stub.cc instead of gpu_cuda.cc and has no device.
//
// Times    median and minimum of the runs, in milliseconds. The L2 cache is overwritten before each
//          run. A gate holds the stream until all work of a run is enqueued, so host time is not
//          counted. Exceptions: LaunchToResult and WallTime use the host's clock, and WallTime does
//          not flush the cache
// Errors   a device error ends the program, because a benchmark without its device means nothing
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

// Measured rates, per second.
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

// One stage of an evaluation. `copy` copies the control points; `rest` follows the last named stage.
struct GpuStage {
  std::string name;
  double device_ms = 0;  // median
  double host_ms = 0;    // median of the time to enqueue it
};

// One evaluation on one device or several, by the host's clock.
struct WallTimes {
  GpuTimes whole;         // until the last device has finished
  double enqueue_ms = 0;  // median: until Evaluate returns
};

// The control nets of all patches, and the time to make them, including the copy of control points.
struct BezierNets {
  std::vector<NetPoint> nets;  // for the first set of control points
  GpuTimes times;
};

// The tensor-product comparator: its stages "copy", "control points" and "rest" (the tessellation),
// and the whole.
struct TensorTimes {
  std::vector<GpuStage> stages;
  GpuTimes whole;
};
// Called once before timing, with the vertices of the first set of control points.
using TensorCheck = std::function<absl::Status(std::span<const TensorVertex> vertices)>;

// Evaluates the timed view once. `run` counts the calls.
using GpuWork = std::function<absl::Status(int run)>;

class Gpu {
 public:
  virtual ~Gpu() = default;
  virtual Backend& backend() = 0;
  virtual const GpuFloors& floors() = 0;  // measured on the first call, in less than a second
  // Evaluates the surfaces of a plan, alternating between two sets of the lattice's control points.
  // Returns the errors of `check`.
  virtual absl::StatusOr<TensorTimes> TensorProduct(
      const std::shared_ptr<const DeformPlan>& plan, const TensorSurfaces& surfaces,
      std::span<const std::vector<Vec3d>, 2> control_points, const TensorCheck& check,
      int runs) = 0;
  // Control nets by formula (6), alternating between two sets of the lattice's control points.
  virtual BezierNets ControlNets(const std::shared_ptr<const DeformPlan>& plan,
                                 std::span<const std::vector<Vec3d>, 2> control_points,
                                 int runs) = 0;

  // Measures one Evaluate of the view, by events around it.
  virtual GpuTimes DeviceTime(DeformView& view, const GpuWork& work, int runs) = 0;
  // The host's clock, from the call of Evaluate until its results are in device memory.
  virtual GpuTimes LaunchToResult(DeformView& view, const GpuWork& work, int runs) = 0;
  // The devices of this machine, and a backend on the first `count` of them. With two or more,
  // every plan spans all of them.
  virtual int device_count() const = 0;
  virtual std::unique_ptr<Backend> OnDevices(int count) = 0;
  // For a view of a backend of OnDevices.
  virtual WallTimes WallTime(DeformView& view, const GpuWork& work, int runs) = 0;
  // Also records events between the stages. The times of a stage that occurs twice are added.
  virtual std::vector<GpuStage> Stages(DeformView& view, const GpuWork& work, int runs) = 0;
  // Formula (24) for patches of degree n, in double, as (18) is.
  virtual GpuTimes Formula24(int n, int segments, int runs) = 0;
};

// Made for device 0 on the first call. kUnimplemented in a build without CUDA, kUnavailable without
// a device.
[[nodiscard]] absl::StatusOr<Gpu*> TheGpu();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_H_
