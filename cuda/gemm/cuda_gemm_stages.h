// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The products of the three GEMM pipelines, for a tile of patches: twin of
// core/cpu/gemm/gemm_stages.h, which has the formulas. (18) and (6) run in double there and here.
//
// Errors   those of cuda_gemm.h and device_buffer.h
// Threads  one at a time; everything is enqueued on the lane, nothing waits
#ifndef LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_
#define LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_

#include <memory>

#include "core/backend.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_stage.h"

namespace latticed {

class CudaGemmStages {
 public:
  // `derivatives`: Pu and Pv are wanted too. `pipeline` is not kFused. Takes BytesToCome from the
  // reservation, less what the stage has taken already.
  [[nodiscard]] static absl::StatusOr<CudaGemmStages> Create(
      Pipeline pipeline, std::shared_ptr<const DeviceStage> stage, bool derivatives,
      DeviceReservation& from, CudaLane& lane);
  // The bytes that Create allocates: its own matrices, and the context's stage and the lane's
  // workspace where they do not exist yet. `degree`: of a patch.
  static uint64_t BytesToCome(Pipeline pipeline, int degree, int segments, CudaContext& context,
                              const CudaLane& lane);

  // Rows of [P; Pu; Pv]: q, or 3q with derivatives.
  size_t rows() const { return rows_; }
  // Whether Apply wants the samples in double: (6) does.
  bool in_double() const { return pipeline_ == Pipeline::kControlNet; }
  const DeviceStage& stage() const { return *stage_; }
  size_t MemoryBytes() const;

  // To be called once per evaluation: (18) is part of the paper's trivial form.
  [[nodiscard]] absl::Status Begin();

  // samples: m x 3t; out: the first out.rows of [P; Pu; Pv], q or rows().
  [[nodiscard]] absl::Status Apply(DeviceMatrix<const float> samples, DeviceMatrix<float> out);
  // kControlNet. T = inv(B) Rs goes to `control`, and as float to `rounded`, both m x 3t.
  [[nodiscard]] absl::Status Apply(DeviceMatrix<const double> samples, DeviceMatrix<double> control,
                                   DeviceMatrix<float> rounded, DeviceMatrix<float> out);

 private:
  CudaGemmStages(Pipeline pipeline, std::shared_ptr<const DeviceStage> stage, bool derivatives,
                 CudaGemm* gemm, cudaStream_t stream);
  DeviceMatrix<float> OwnStack() const;

  Pipeline pipeline_;
  std::shared_ptr<const DeviceStage> stage_;
  size_t rows_;
  CudaGemm* gemm_;  // of the lane
  cudaStream_t stream_;
  DeviceBuffer<double> product_;   // kGemm12: [Bb; Bbu; Bbv], made anew by Begin
  DeviceBuffer<float> own_stack_;  // the same, rounded
};

}  // namespace latticed

#endif  // LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_
