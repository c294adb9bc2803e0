// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The products of the three GEMM pipelines, for a tile of patches. Twin of
// core/cpu/gemm/gemm_stages.h, which has the formulas. Both compute (18) and (6) in double.
//
// Errors   those of cuda_gemm.h and device_buffer.h
// Threads  one at a time; enqueues on the lane and does not wait
#ifndef LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_
#define LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_

#include <memory>

#include "core/backend.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_stage.h"

namespace latticed {

class CudaGemmStages {
 public:
  // `derivatives`: whether Pu and Pv are computed too. `pipeline` is not kFused. Takes BytesToCome
  // from the reservation, less what making the stage has taken from it.
  [[nodiscard]] static absl::StatusOr<CudaGemmStages> Create(
      Pipeline pipeline, std::shared_ptr<const DeviceStage> stage, bool derivatives,
      DeviceReservation& from, CudaLane& lane);
  // The bytes that Create and making the stage allocate: own matrices, and the context's stage and
  // the lane's workspace if they do not exist yet. `degree`: that of a patch.
  static uint64_t BytesToCome(Pipeline pipeline, int degree, int segments, CudaContext& context,
                              const CudaLane& lane);

  // Rows of [P; Pu; Pv]: q, or 3q with derivatives.
  size_t rows() const { return rows_; }
  // Whether Apply takes the samples in double, as (6) needs.
  bool in_double() const { return pipeline_ == Pipeline::kControlNet; }
  const DeviceStage& stage() const { return *stage_; }
  size_t MemoryBytes() const;

  // Called once per evaluation: kGemm12, the paper's trivial form, computes (18) each time.
  [[nodiscard]] absl::Status Begin();

  // kGemm and kGemm12. samples: m x 3t. out: the first out.rows of [P; Pu; Pv], q or rows().
  [[nodiscard]] absl::Status Apply(DeviceMatrix<const float> samples, DeviceMatrix<float> out);
  // kControlNet. Writes T = inv(B) Rs to `control`, and rounded to float to `rounded`, both m x 3t.
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
  DeviceBuffer<double> product_;   // kGemm12: [Bb; Bbu; Bbv], computed by each Begin
  DeviceBuffer<float> own_stack_;  // the same, rounded
};

}  // namespace latticed

#endif  // LATTICED_CUDA_GEMM_CUDA_GEMM_STAGES_H_
