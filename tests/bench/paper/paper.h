// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench paper: the tables of Cui & Feng 2014 (doi 10.1007/s11766-014-3239-6) with the times
// of this machine beside every figure, for meshes with the patch counts of their models (exact_mesh.h).
//
//   Tables 1 to 3  the paper's figures, ours, and the ratios (beside_paper.h)
//   points         shaders, tensor product, gemm and fused: nanoseconds a point
//   counts         formula (20) and its corrected count, beside the times of Methods 1 and 2
//
// Facet normals, float32, degree 2 x 2 x 2, 10 segments. Every view is compared with the definition
// before it is timed. Without a GPU, only the CPU's columns are measured.
#ifndef LATTICED_TESTS_BENCH_PAPER_PAPER_H_
#define LATTICED_TESTS_BENCH_PAPER_PAPER_H_

#include <vector>

#include "tests/bench/report/report.h"

namespace latticed::bench {

[[nodiscard]] std::vector<Section> PaperTables();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_PAPER_H_
