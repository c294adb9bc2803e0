// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a plan of a run of another plan's chunks: all that one of several devices needs for them.
//
//   patch p of the slice                   patch 32 first_chunk + p of the plan
//   boxes, seams, identity points, origin  the plan's
//   vertices, mesh corners                 those that the run names, in their order, numbered anew
//   edges                                  those that the run names, numbered by its own first use, as in every plan
//
// A patch takes every shared point from the box that owns it (deform_plan.h), and a slice has all boxes. Pipeline
// kFused therefore gives the points of a slice the same bits as with the whole plan. The GEMM pipelines copy shared
// points from other patches, which a slice may lack.
//
// `mesh` has positions and corners of the run alone, and no faces; box_borrowers is empty. mesh_bounds and the counts
// of patches stay those of the plan. Slices are evaluated, but not edited or exported.
//
// Threads  pure
#ifndef LATTICED_CORE_FFD_PLAN_PLAN_SLICE_H_
#define LATTICED_CORE_FFD_PLAN_PLAN_SLICE_H_

#include <cstddef>
#include <memory>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

// Chunks [first_chunk, last_chunk) of the plan; at least one. Throws std::bad_alloc.
[[nodiscard]] std::shared_ptr<const DeformPlan> SlicePlan(const DeformPlan& plan,
                                                          size_t first_chunk, size_t last_chunk);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_PLAN_SLICE_H_
