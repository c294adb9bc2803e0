// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tensor-product comparator (tensor_product.h) on the CUDA device: control points of all
// surfaces, then the vertices of their trimmed grids.
//
// Stages   "copy", "control points", and the rest
// Errors   kResourceExhausted; those of the device
// Threads  one; Enqueue puts a copy of the control points and two kernels on the lane, nothing waits
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_MAKER_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_MAKER_H_

#include <memory>
#include <span>
#include <vector>

#include "tests/bench/paper/device_lattice.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"

namespace latticed::bench {

class TensorProductMaker {
 public:
  // On a lane of its own; `surfaces` are those of the plan.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<TensorProductMaker>> Create(
      const std::shared_ptr<const DeformPlan>& plan, const TensorSurfaces& surfaces,
      CudaContext& context);

  [[nodiscard]] absl::Status Enqueue(std::span<const Vec3d> control_points);
  // What the last Enqueue made; waits for it.
  [[nodiscard]] absl::StatusOr<std::vector<TensorVertex>> Download() const;
  CudaLane& lane() const { return lattice_.lane(); }

 private:
  struct Buffers {
    DeviceBuffer<TensorSurface> surfaces;
    DeviceBuffer<TensorLine> lines;
    DeviceBuffer<TensorPoint> points;
    DeviceBuffer<TensorInverse> inverse;
    DeviceBuffer<Vec3d> centres;
    DeviceBuffer<float> control;
    DeviceBuffer<TensorVertex> vertices;
  };

  TensorProductMaker(size_t most_lines, DeviceLattice lattice, Buffers buffers);

  size_t most_lines_;
  DeviceLattice lattice_;
  Buffers buffers_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_MAKER_H_
