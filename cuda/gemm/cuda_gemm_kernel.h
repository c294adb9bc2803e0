// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pipelines kGemm, kGemm12 and kControlNet on the device. The steps are samples, products, normals
// and shared points. Twin of core/cpu/gemm/gemm_kernel.h.
//
// Each evaluation divides all patches into the same tiles: cuBLAS may round differently for another
// shape, and the same control points must give the same bits. The buffers of a tile are reserved
// together at the first evaluation and stay with the view.
//
// Errors   those of cuda_gemm_stages.h; kResourceExhausted for the buffers
// Threads  one at a time; enqueues on the lane and does not wait
#ifndef LATTICED_CUDA_GEMM_CUDA_GEMM_KERNEL_H_
#define LATTICED_CUDA_GEMM_CUDA_GEMM_KERNEL_H_

#include <memory>

#include "cuda/gemm/cuda_gemm_stages.h"
#include "cuda/gemm/gemm_kernels.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

class CudaGemmKernel : public CudaVertexKernel {
 public:
  // Takes CudaGemmStages::BytesToCome and the plan's BytesToCome from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaGemmKernel>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
      Pipeline pipeline, const ViewSpec& spec, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane, DeviceReservation& from);

  // Of a tile's matrices, on a device with that budget. It decides how many patches a tile has.
  [[nodiscard]] static uint64_t MostTileBytes(uint64_t budget_bytes);

  absl::Status Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, DeviceSpan<uint8_t> vertices) override;
  MemoryUse memory() const override;

 private:
  // ℝs and what the products make of it, for tile_patches_ patches.
  struct Buffers {
    DeviceBuffer<float> samples, by_normal;                  // m x 3t; kControlNet: T, rounded
    DeviceBuffer<double> samples_d, by_normal_d, control_d;  // m x 3t; kControlNet only
    DeviceBuffer<float> surface;                             // [P; Pu; Pv], rows x 3t
    DeviceBuffer<float> across;                              // Pf, q x 3t; smooth only
    DeviceBuffer<uint32_t> ill;                              // with normals only
    DeviceBuffer<Vec3d> centres;
    size_t bytes() const;
  };

  CudaGemmKernel(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
                 const ViewSpec& spec, std::shared_ptr<CudaContext> context,
                 std::shared_ptr<CudaLane> lane, CudaGemmStages stages, kernels::PlanTables tables);
  bool smooth() const { return spec_.normals == NormalMode::kSmooth; }
  size_t TilePatches() const;
  absl::Status Allocate();
  absl::Status EvaluateTile(const kernels::Tile& tile, const VertexWriter& writer,
                            DeviceSpan<uint8_t> vertices);
  absl::Status Products(const kernels::Tile& tile);
  template <typename T>
  absl::Status Sample(const kernels::Tile& tile, T* positions, T* by_normal);
  // Multiplies `samples` into `out`. kControlNet multiplies `in_double` instead, and writes its
  // control nets, rounded, to `samples`.
  absl::Status Apply(const kernels::Tile& tile, const DeviceBuffer<double>& in_double,
                     const DeviceBuffer<float>& samples, const DeviceBuffer<float>& out,
                     size_t rows);

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<DevicePlan> device_plan_;
  ViewSpec spec_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  CudaGemmStages stages_;
  kernels::PlanTables tables_;
  size_t tile_patches_;
  Buffers buffers_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_GEMM_CUDA_GEMM_KERNEL_H_
