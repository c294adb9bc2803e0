// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pipeline kFused on the device. It computes the polynomials of all boxes, or of those that the frame
// names, and then the vertices of the named chunks in the lane order of fused_kernels.h. Twin of
// core/cpu/fused/cpu_fused.h.
//
// Errors   those of device_buffer.h and staged_upload.h
// Threads  one at a time. Calls enqueue on the lane; ToWireOrder waits until the list of its last call
//          has been copied
#ifndef LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_
#define LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_

#include <memory>

#include "cuda/device/launch_graph.h"
#include "cuda/fused/fused_kernels.h"
#include "cuda/fused/polynomial_memory.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

class CudaFusedKernel : public CudaVertexKernel {
 public:
  // `device_plan` was made for kFused. Takes DeviceBytesFor and the plan's BytesToCome from the
  // reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaFusedKernel>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
      const ViewSpec& spec, CudaContext& context, std::shared_ptr<CudaLane> lane,
      DeviceReservation& from);
  static uint64_t DeviceBytesFor(const DeformPlan& plan);
  // The bytes of all vertices in lane order.
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
  // Evaluate fills the polynomials; ToWireOrder fills the list of chunks.
  struct Buffers {
    StagedUpload wire_chunks;
    PolynomialMemory polynomials;
  };
  CudaFusedKernel(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
                  const ViewSpec& spec, std::shared_ptr<CudaLane> lane, kernels::PlanTables tables,
                  Buffers buffers);
  absl::Status CountBlocksAtOnce(int device);
  // Returns the list on the device.
  absl::StatusOr<const kernels::WireChunk*> SendWireChunks(std::span<const uint32_t> chunks);
  // Launches the calls as a graph, or by stages. `part`: the frame has a part of the lattice.
  absl::Status LaunchAll(std::span<kernels::KernelCall> calls, bool part);
  // Launches the kernels one by one and marks each stage. Marks are impossible between the kernels
  // of a graph.
  absl::Status LaunchByStages(std::span<kernels::KernelCall> calls);
  kernels::BoxPolynomials Polynomials(const QuantisationBox& box) const;
  kernels::FusedOutput Output(uint8_t* vertices) const;
  // The bytes before the second plane of quantised vertices.
  size_t FirstPlaneBytes() const;

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<DevicePlan> device_plan_;
  ViewSpec spec_;
  std::shared_ptr<CudaLane> lane_;
  kernels::PlanTables tables_;
  Buffers buffers_;
  int blocks_at_once_ = 1;  // how many blocks of FusedCall the device holds at once
  // For evaluations that upload the whole lattice, and for those that upload a part of it. Their
  // kernels differ.
  LaunchGraph graph_, part_graph_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_FUSED_CUDA_FUSED_KERNEL_H_
