// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench paper: measures on this machine what the tables of Cui & Feng 2014 (doi
// 10.1007/s11766-014-3239-6) compare, with the patch counts of their models (exact_mesh.h). Figures
// of the paper that are known here are shown too. The others are "not known"; none is estimated.
//
//   products    trivial form, (18) and (21)-(23), against the optimal form, (24) and (25)
//   devices     the trivial, optimal and fused forms on the CPU and on the GPU
//   stages      edit, copy, samples, (24), (25), rearranging
//   algorithms  the tensor product of 2013, and tessellation shaders: per model and per point
//   counts      formula (20) and its corrected count, beside the times of Methods 1 and 2
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
