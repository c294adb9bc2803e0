// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/gemm/cuda_gemm_stages.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/box/bernstein.h"
#include "core/ffd/tessellation_pattern.h"
#include "cuda/device/cuda_status.h"
#include "cuda/gemm/gemm_kernels.h"

namespace latticed {
namespace {

// The elements of [Bb; Bbu; Bbv].
size_t OwnElements(size_t m, size_t q) { return 3 * q * m; }

}  // namespace

CudaGemmStages::CudaGemmStages(Pipeline pipeline, std::shared_ptr<const DeviceStage> stage,
                               bool derivatives, CudaGemm* gemm, cudaStream_t stream)
    : pipeline_(pipeline),
      stage_(std::move(stage)),
      rows_(derivatives ? 3 * stage_->q() : stage_->q()),
      gemm_(gemm),
      stream_(stream) {}

uint64_t CudaGemmStages::BytesToCome(Pipeline pipeline, int degree, int segments,
                                     CudaContext& context, const CudaLane& lane) {
  const size_t own = pipeline == Pipeline::kGemm12
                         ? OwnElements(static_cast<size_t>(BernsteinCount(degree)),
                                       static_cast<size_t>(PointsPerPatch(segments)))
                         : 0;
  return context.StageBytesToCome(degree, segments) + lane.GemmBytesToCome() +
         own * (sizeof(double) + sizeof(float));
}

absl::StatusOr<CudaGemmStages> CudaGemmStages::Create(Pipeline pipeline,
                                                      std::shared_ptr<const DeviceStage> stage,
                                                      bool derivatives, DeviceReservation& from,
                                                      CudaLane& lane) {
  LATTICED_ASSIGN_OR_RETURN(const auto gemm, lane.gemm(from));
  CudaGemmStages stages(pipeline, std::move(stage), derivatives, gemm, lane.stream().get());
  if (pipeline != Pipeline::kGemm12) return stages;
  const size_t elements = OwnElements(stages.stage_->m(), stages.stage_->q());
  LATTICED_ASSIGN_OR_RETURN(
      auto product, DeviceBuffer<double>::Create(from, "stage_matrices", elements, stages.stream_));
  LATTICED_ASSIGN_OR_RETURN(auto own_stack, DeviceBuffer<float>::Create(from, "stage_matrices",
                                                                        elements, stages.stream_));
  stages.product_ = std::move(product);
  stages.own_stack_ = std::move(own_stack);
  return stages;
}

size_t CudaGemmStages::MemoryBytes() const {
  return stage_->MemoryBytes() + product_.size_bytes() + own_stack_.size_bytes();
}

DeviceMatrix<float> CudaGemmStages::OwnStack() const {
  return {own_stack_.data(), 3 * stage_->q(), stage_->m(), 3 * stage_->q()};
}

absl::Status CudaGemmStages::Begin() {
  if (pipeline_ != Pipeline::kGemm12) return absl::OkStatus();
  const size_t m = stage_->m(), q = stage_->q();
  const DeviceMatrix<double> product{product_.data(), 3 * q, m, 3 * q};
  for (size_t first = 0; first < 3 * q; first += q) {
    LATTICED_RETURN_IF_ERROR(gemm_->Multiply(stage_->bernstein().Rows(first, q), stage_->inverse(),
                                             product.Rows(first, q)));
  }
  return CudaStatus(
      kernels::LaunchRound(product_.data(), product_.size(), own_stack_.data(), stream_),
      "formula (18)");
}

absl::Status CudaGemmStages::Apply(DeviceMatrix<const float> samples, DeviceMatrix<float> out) {
  if (pipeline_ == Pipeline::kGemm) {
    return gemm_->Multiply(stage_->stack().Rows(0, out.rows), samples, out);
  }
  const size_t q = stage_->q(), patches = samples.columns / 3;
  for (size_t first = 0; first < out.rows; first += q) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t column = axis * patches;
      LATTICED_RETURN_IF_ERROR(gemm_->Multiply(OwnStack().Rows(first, q),
                                               samples.Columns(column, patches),
                                               out.Rows(first, q).Columns(column, patches)));
    }
  }
  return absl::OkStatus();
}

absl::Status CudaGemmStages::Apply(DeviceMatrix<const double> samples, DeviceMatrix<double> control,
                                   DeviceMatrix<float> rounded, DeviceMatrix<float> out) {
  LATTICED_RETURN_IF_ERROR(gemm_->Multiply(stage_->inverse(), samples, control));
  LATTICED_RETURN_IF_ERROR(CudaStatus(
      kernels::LaunchRound(control.data, control.rows * control.columns, rounded.data, stream_),
      "the control nets"));
  return gemm_->Multiply(stage_->bernstein_f().Rows(0, out.rows), rounded, out);
}

}  // namespace latticed
