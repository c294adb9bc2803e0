// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The paper's comparators on the CUDA device. Each has a copy of the lattice, on its own lane.
//
// Stages   of the tensor product: "copy", "control points" and "rest"
// Errors   end the program
// Threads  one. Enqueue puts a copy of the control points and the kernels on the lane, and does not
//          wait. Download waits for the results of the last Enqueue
#ifndef LATTICED_TESTS_BENCH_PAPER_COMPARATORS_H_
#define LATTICED_TESTS_BENCH_PAPER_COMPARATORS_H_

#include <memory>
#include <span>
#include <vector>

#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "cuda/view/cuda_frame.h"
#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

class DeviceLattice {
 public:
  DeviceLattice(std::shared_ptr<const DeformPlan> plan, CudaContext& context);

  template <class T>
  DeviceBuffer<T> Upload(const std::vector<T>& from) {
    return Checked(DeviceBuffer<T>::Upload(memory_, kPurpose, from, stream()));
  }
  template <class T>
  DeviceBuffer<T> Allocate(size_t count) {
    return Checked(DeviceBuffer<T>::Create(memory_, kPurpose, count, stream()));
  }
  template <class T>
  std::vector<T> Download(const DeviceBuffer<T>& from) const {
    std::vector<T> to(from.size());
    CheckOk(CudaStatus(cudaMemcpyAsync(to.data(), from.data(), from.size_bytes(),
                                       cudaMemcpyDeviceToHost, stream()),
                       kPurpose));
    CheckOk(lane_->stream().Synchronize(kPurpose));
    return to;
  }
  void Send(std::span<const Vec3d> control_points) { CheckOk(frame_.Upload(control_points)); }
  // Relative to the plan's local origin, like the control points on the device.
  VolumeView volume() const;
  CudaLane& lane() const { return *lane_; }
  cudaStream_t stream() const { return lane_->stream().get(); }

 private:
  static constexpr char kPurpose[] = "comparator";

  CudaFrame MakeFrame(CudaContext& context) const;

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<DeviceMemory> memory_;
  std::shared_ptr<CudaLane> lane_;
  CudaFrame frame_;
  DeviceBuffer<double> knots_;  // of u, v, w in order
};

// Computes the control points of all patches of a plan by formula (6) (bezier_net.h).
class BezierNetMaker {
 public:
  BezierNetMaker(const std::shared_ptr<const DeformPlan>& plan, CudaContext& context);
  void Enqueue(std::span<const Vec3d> control_points);
  std::vector<NetPoint> Download() const { return lattice_.Download(nets_); }
  CudaLane& lane() const { return lattice_.lane(); }

 private:
  DeviceLattice lattice_;
  int m_;
  DeviceBuffer<NetPatch> patches_;
  DeviceBuffer<NetTables> tables_;
  DeviceBuffer<NetPoint> nets_;
};

// Computes the control points of all surfaces of a plan, then the vertices of their trimmed grids
// (tensor_product.h).
class TensorProductMaker {
 public:
  TensorProductMaker(const std::shared_ptr<const DeformPlan>& plan, const TensorSurfaces& surfaces,
                     CudaContext& context);
  void Enqueue(std::span<const Vec3d> control_points);
  std::vector<TensorVertex> Download() const { return lattice_.Download(vertices_); }
  CudaLane& lane() const { return lattice_.lane(); }

 private:
  DeviceLattice lattice_;
  size_t most_lines_;
  DeviceBuffer<TensorSurface> surfaces_;
  DeviceBuffer<TensorLine> lines_;
  DeviceBuffer<TensorPoint> points_;
  DeviceBuffer<TensorInverse> inverse_;
  DeviceBuffer<Vec3d> centres_;
  DeviceBuffer<float> control_;
  DeviceBuffer<TensorVertex> vertices_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_COMPARATORS_H_
