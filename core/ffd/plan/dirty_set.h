// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The chunks that an edit touches.
//
// Control point (i,j,k) influences the boxes whose spans are in i … i+nu, j … j+nv, k … k+nw. Its move makes the chunks
// of all patches in those boxes dirty. It does so also with the chunks of patches elsewhere that have a vertex or edge
// owned by one of those boxes: re-evaluating the owner can change the last bits of points that the edit cannot move.
// A control point of a turned lattice makes the patches dirty that have a vertex in its basis function's support, faces
// included: there are the patches that it moves, and all that share a vertex or edge with them.
//
// Threads  pure functions
#ifndef LATTICED_CORE_FFD_PLAN_DIRTY_SET_H_
#define LATTICED_CORE_FFD_PLAN_DIRTY_SET_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

// By box, the outside box last: whether one of the control points influences it, or those of turned lattices a patch in it.
[[nodiscard]] std::vector<bool> InfluencedBoxes(const DeformPlan& plan,
                                                std::span<const uint32_t> indices);

struct DirtySet {
  std::vector<uint32_t> chunks;  // ascending
  // For EditResult: the boxes, and the patches in them or with a vertex or edge that they own.
  uint64_t boxes = 0, patches = 0;
};

// What the control points with these indices influence, each of which may be named more than once. The indices must be
// in range.
[[nodiscard]] DirtySet DirtyByControlPoints(const DeformPlan& plan,
                                            std::span<const uint32_t> indices);
[[nodiscard]] DirtySet AllDirty(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_DIRTY_SET_H_
