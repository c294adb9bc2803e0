// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The convex polygons from which the patches were cut: the part of a source triangle in one knot box.
//
//   A plan keeps patches only. The patches of one source triangle and one box are joined again, and
//   the polygon's sides are the edges that no two of them share.
//
// Errors   kUnimplemented if patches lie outside the frame; kInternal if the patches of a triangle and
//          a box are no polygon
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TRIMMING_SUB_POLYGONS_H_
#define LATTICED_TESTS_BENCH_PAPER_TRIMMING_SUB_POLYGONS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed::bench {

struct SubPolygon {
  std::vector<uint32_t> patches;  // ascending
  std::vector<uint32_t> corners;  // vertices of the plan, in the winding of the source
};

// In the order of their first patches, which sorts them by box.
[[nodiscard]] absl::StatusOr<std::vector<SubPolygon>> FindSubPolygons(const DeformPlan& plan);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TRIMMING_SUB_POLYGONS_H_
