// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench tolerance: views with a tolerance against 10 uniform segments, for meshes with the paper's patch counts
// (exact_mesh.h) and for real meshes. Degree 2 x 2 x 2, facet normals, float32. D is the diagonal of the deformed surface.
//
//   equal error  the tolerance is the largest true error of the uniform view, sampled at the middles of its triangles and of
//                their sides
//   1e-4 D       what a drawing of 1,000 pixels shows a tenth of a pixel of
//
// Times are of a whole evaluation for new control points, medians, on all threads. A view whose certificate is below its
// sampled error ends the program.
#ifndef LATTICED_TESTS_BENCH_TOLERANCE_TOLERANCE_TABLE_H_
#define LATTICED_TESTS_BENCH_TOLERANCE_TOLERANCE_TABLE_H_

#include <vector>

#include "tests/bench/report/report.h"

namespace latticed::bench {

// A section for each backend that this machine has.
[[nodiscard]] std::vector<Section> ToleranceTables();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TOLERANCE_TOLERANCE_TABLE_H_
