// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tables 1 to 3 of the paper (printed_tables.h) with our times beside every figure, stage by stage
// and model by model.
//
//   1  the products alone: the trivial form against the optimal form
//   2  whole evaluations: CUDA, tessellation shaders, CPU
//   3  stages: the tensor product of 2013, and the paper's algorithm
//
// Our times of the paper's algorithm are those of pipeline gemm. `fused` is beside them wherever a
// figure is a whole evaluation.
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_BESIDE_PAPER_H_
#define LATTICED_TESTS_BENCH_PAPER_BESIDE_PAPER_H_

#include <span>

#include "tests/bench/paper/paper_measure.h"
#include "tests/bench/paper/printed_tables.h"
#include "tests/bench/report/report.h"

namespace latticed::bench {

// Our times for the model of kPaperModels with the same index.
struct PaperTimes {
  PaperGpuTimes gpu;
  PaperCpuTimes cpu;
};
using AllPaperTimes = std::span<const PaperTimes, kPaperModelCount>;

[[nodiscard]] Section BesideTable1(AllPaperTimes times);
[[nodiscard]] Section BesideTable2(AllPaperTimes times);
[[nodiscard]] Section BesideTable3(AllPaperTimes times);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_BESIDE_PAPER_H_
