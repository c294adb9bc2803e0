// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pipeline kFused on the device: box polynomials, of all boxes or those that the frame names, then
// vertices of the chunks asked, in the lane order of fused_kernels.h. Twin of
// core/cpu/fused/fused_view_kernel.h.
//
// Errors   those of device_buffer.h and staged_upload.h
// Threads  one at a time; enqueues on the lane, and waits only where ToWireOrder's list is still on
//          its way from the last call
#ifndef LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_
#define LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_

#include <memory>

#include "cuda/device/launch_graph.h"
#include "cuda/fused/fused_kernels.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

class CudaFusedKernel : public CudaVertexKernel {
 public:
  // `device_plan` was made for kFused. Of bytes reserved: DeviceBytesFor, and the plan's BytesToCome.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaFusedKernel>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
      const ViewSpec& spec, CudaContext& context, std::shared_ptr<CudaLane> lane,
      DeviceReservation& from);
  static uint64_t DeviceBytesFor(const DeformPlan& plan);
  // Of all vertices in lane order.
  static size_t LaneOrderBytes(const DeformPlan& plan, const ViewSpec& spec);

  absl::Status Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, DeviceSpan<uint8_t> vertices) override;
  MemoryUse memory() const override;
  std::shared_ptr<const ChunkNeeds> chunk_needs() const override {
    return device_plan_->chunk_needs();
  }
  size_t OwnOrderBytes() const override { return LaneOrderBytes(*plan_, spec_); }
  absl::Status ToWireOrder(DeviceSpan<const uint8_t> vertices, std::span<const uint32_t> chunks,
                           DeviceSpan<uint8_t> out) override;

 private:
  // What is uploaded or computed for each evaluation.
  struct Buffers {
    StagedUpload wire_chunks;
    DeviceBuffer<float> coefficients, cofactor_bounds;
  };
  CudaFusedKernel(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
                  const ViewSpec& spec, std::shared_ptr<CudaLane> lane, kernels::PlanTables tables,
                  Buffers buffers);
  absl::Status CountBlocksAtOnce(int device);
  // One by one, each stage marked: between kernels of a graph nothing can be.
  absl::Status LaunchByStages(std::span<kernels::KernelCall> calls);
  kernels::BoxPolynomials Polynomials(const QuantisationBox& box) const;
  kernels::FusedOutput Output(uint8_t* vertices) const;
  // Of the second plane of quantised vertices.
  size_t FirstPlaneBytes() const;

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<DevicePlan> device_plan_;
  ViewSpec spec_;
  std::shared_ptr<CudaLane> lane_;
  kernels::PlanTables tables_;
  Buffers buffers_;
  int blocks_at_once_ = 1;  // that the device holds
  // Of evaluations that bring the whole lattice, and of those that bring a part: other kernels.
  LaunchGraph graph_, part_graph_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_
