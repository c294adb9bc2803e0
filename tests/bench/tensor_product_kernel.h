// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tensor-product comparator (tensor_product.h) as a kernel of a CUDA view, so that it is
// verified and timed by the very code that verifies and times our own pipelines. Shared points stay
// as each patch has them: that algorithm is not watertight.
//
// Errors   kUnimplemented for patches that are not of degree 6; kResourceExhausted
// Threads  as CudaVertexKernel
#ifndef LATTICED_TESTS_BENCH_TENSOR_PRODUCT_KERNEL_H_
#define LATTICED_TESTS_BENCH_TENSOR_PRODUCT_KERNEL_H_

#include <memory>

#include "cuda/view/cuda_vertex_kernel.h"
#include "cuda/view/cuda_view.h"
#include "tests/bench/tensor_product.h"

namespace latticed::bench {

class TensorProductKernel : public CudaVertexKernel {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<TensorProductKernel>> Create(
      std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec, CudaContext& context,
      std::shared_ptr<CudaLane> lane);

  // Always all chunks.
  absl::Status Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, DeviceSpan<uint8_t> vertices) override;
  MemoryUse memory() const override;

 private:
  struct Buffers {
    DeviceBuffer<double> knots;  // of u, then v, then w
    DeviceBuffer<TensorPatch> patches;
    DeviceBuffer<TensorTables> tables;
    DeviceBuffer<Vec3d> centres;
    DeviceBuffer<float> control;
  };

  TensorProductKernel(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                      std::shared_ptr<CudaLane> lane, Buffers buffers);
  VolumeView Volume(const Vec3d* control_points) const;

  std::shared_ptr<const DeformPlan> plan_;
  ViewSpec spec_;
  std::shared_ptr<CudaLane> lane_;
  Buffers buffers_;
};

// A view on a lane of its own.
[[nodiscard]] absl::StatusOr<std::unique_ptr<DeformView>> MakeTensorProductView(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
    std::shared_ptr<CudaContext> context);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TENSOR_PRODUCT_KERNEL_H_
