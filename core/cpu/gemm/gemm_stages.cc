// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/gemm_stages.h"

#include <algorithm>

#include "core/base/status_macros.h"
#include "core/cpu/gemm/cpu_gemm.h"

namespace latticed {
namespace {

void Round(const double* from, size_t count, std::vector<float>& to) {
  to.resize(count);
  std::transform(from, from + count, to.begin(), [](double x) { return static_cast<float>(x); });
}

}  // namespace

GemmStages::GemmStages(Pipeline pipeline, const StageMatrices& stage, bool derivatives)
    : pipeline_(pipeline), stage_(stage), rows_(derivatives ? 3 * stage.q : stage.q) {}

size_t GemmStages::MemoryBytes() const {
  return stage_.MemoryBytes() + own_stack_.capacity() * sizeof(float);
}

MatrixView<const float> GemmStages::Rows(const std::vector<float>& stack, size_t first,
                                         size_t count) const {
  return {stack.data() + first, count, stage_.m, 3 * stage_.q};
}

absl::Status GemmStages::Begin() {
  if (pipeline_ != Pipeline::kGemm12) return absl::OkStatus();
  const size_t m = stage_.m, q = stage_.q;
  std::vector<double> product(3 * q * m);
  for (size_t block = 0; block < 3; ++block) {
    LATTICED_RETURN_IF_ERROR(
        CpuGemm(MatrixView<const double>{stage_.bernstein.data() + block * q, q, m, 3 * q},
                MatrixView<const double>{stage_.inverse.data(), m, m, m},
                MatrixView<double>{product.data() + block * q, q, m, 3 * q}));
  }
  Round(product.data(), product.size(), own_stack_);
  return absl::OkStatus();
}

absl::Status GemmStages::Apply(MatrixView<const double> samples, MatrixView<float> out,
                               Scratch& scratch) const {
  const size_t m = stage_.m, columns = samples.columns;
  if (pipeline_ == Pipeline::kControlNet) {
    scratch.control.resize(m * columns);
    const MatrixView<double> control{scratch.control.data(), m, columns, m};
    LATTICED_RETURN_IF_ERROR(
        CpuGemm(MatrixView<const double>{stage_.inverse.data(), m, m, m}, samples, control));
    Round(control.data, m * columns, scratch.rounded);
    return CpuGemm(Rows(stage_.bernstein_f, 0, out.rows),
                   MatrixView<const float>{scratch.rounded.data(), m, columns, m}, out);
  }
  Round(samples.data, m * columns, scratch.rounded);
  const MatrixView<const float> input{scratch.rounded.data(), m, columns, m};
  if (pipeline_ == Pipeline::kGemm12) return ApplyNine(input, out);
  return CpuGemm(Rows(stage_.stack, 0, out.rows), input, out);
}

absl::Status GemmStages::ApplyNine(MatrixView<const float> samples, MatrixView<float> out) const {
  const size_t q = stage_.q, patches = samples.columns / 3;
  for (size_t first = 0; first < out.rows; first += q) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t column = axis * patches;
      LATTICED_RETURN_IF_ERROR(CpuGemm(
          Rows(own_stack_, first, q),
          MatrixView<const float>{&samples(0, column), samples.rows, patches, samples.stride},
          MatrixView<float>{&out(first, column), q, patches, out.stride}));
    }
  }
  return absl::OkStatus();
}

}  // namespace latticed
