// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The distinct corners and edges of each chunk. Several patches of a chunk use the same corner or edge, and
// a block evaluates it once: 55 to 65 edges and 25 corners for 96 uses of each.
//
//   edges     9 bits for each edge of the patch: number in the chunk (7), reversed (1), first use (1)
//   corners   8 bits for each corner: number in the chunk (7), first use (1)
//
// The first use of a corner or edge, by patch and then by slot, says which box owns it and in which
// direction it is evaluated. Numbers count the first uses.
//
// Threads  plain data; PackFeatureUses is pure
#ifndef LATTICED_CUDA_PLAN_FEATURE_USES_H_
#define LATTICED_CUDA_PLAN_FEATURE_USES_H_

#include <cstdint>
#include <vector>

#include "core/base/host_device.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {
namespace kernels {

struct FeatureUses {
  uint32_t edges, corners;

  LATTICED_HD uint32_t Edge(int slot) const { return edges >> (9 * slot) & 127; }
  LATTICED_HD bool IsReversed(int slot) const { return (edges >> (9 * slot + 7) & 1) != 0; }
  LATTICED_HD bool IsFirstOfEdge(int slot) const { return (edges >> (9 * slot + 8) & 1) != 0; }
  LATTICED_HD uint32_t Corner(int slot) const { return corners >> (8 * slot) & 127; }
  LATTICED_HD bool IsFirstOfCorner(int slot) const { return (corners >> (8 * slot + 7) & 1) != 0; }
};

}  // namespace kernels

// The uses of one patch.
[[nodiscard]] std::vector<kernels::FeatureUses> PackFeatureUses(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_FEATURE_USES_H_
