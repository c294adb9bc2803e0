// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The products of the three GEMM pipelines, for a tile of patches. Formulas of Cui & Feng
// 2014.
//
//   kGemm        [P; Pu; Pv] = stack * Rs                              (24) once, (25): one product
//   kGemm12      Bb = Bq inv(B), Bbu, Bbv (18); nine products P_x = Bb Rs_x, … (21)-(23)
//   kControlNet  T = inv(B) Rs (6); [P; Pu; Pv] = [Bq; Bqu; Bqv] T     (17)
//
//   Rs: m x 3t    P, Pu, Pv: q x 3t    t patches; columns x of all patches, then y, then z
//   (18) and (6) run in double: inv(B) has entries up to 1,130, which would cost float32 three digits.
//   Smooth normals take one more product of the same kind: Pf = Bb Rf, the derivative across the
//   facet.
//
// Errors   those of CpuGemm
// Threads  Apply is const; a Scratch belongs to one thread
#ifndef LATTICED_CORE_CPU_GEMM_GEMM_STAGES_H_
#define LATTICED_CORE_CPU_GEMM_GEMM_STAGES_H_

#include <vector>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/base/matrix_view.h"
#include "core/ffd/stage_matrices.h"

namespace latticed {

class GemmStages {
 public:
  // `derivatives`: Pu and Pv are wanted too. pipeline is not kFused.
  GemmStages(Pipeline pipeline, const StageMatrices& stage, bool derivatives);

  // Rows of what Apply writes: q, or 3q with derivatives.
  size_t rows() const { return rows_; }
  size_t MemoryBytes() const;

  // Call once per evaluation: the paper's plain form includes (18).
  [[nodiscard]] absl::Status Begin();

  struct Scratch {
    std::vector<float> rounded;   // m x 3t, Rs or T as float
    std::vector<double> control;  // m x 3t, T
  };
  // samples: m x 3t doubles; out: row_count x 3t floats, the first row_count of [P; Pu; Pv].
  // row_count is q or rows().
  [[nodiscard]] absl::Status Apply(MatrixView<const double> samples, MatrixView<float> out,
                                   Scratch& scratch) const;

 private:
  [[nodiscard]] absl::Status ApplyNine(MatrixView<const float> samples,
                                       MatrixView<float> out) const;
  MatrixView<const float> Rows(const std::vector<float>& stack, size_t first, size_t count) const;

  Pipeline pipeline_;
  const StageMatrices& stage_;
  size_t rows_;
  std::vector<float> own_stack_;  // kGemm12: [Bb; Bbu; Bbv], made anew by Begin
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_GEMM_STAGES_H_
