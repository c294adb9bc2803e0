// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The distinct corners and edges of each chunk, so that a block evaluates each of them once though
// several of its patches use it: 55 to 65 edges for 96 uses, 25 corners.
//
//   edges     9 bits an edge of the patch: number in the chunk (7), runs against it (1), first use (1)
//   corners   8 bits a corner: number in the chunk (7), first use (1)
//
// The first use of a corner or edge, by patch and then by slot, stands for all: it says which box
// owns it and which way it runs. Numbers count the first uses.
//
// Threads  plain data; PackFeatureUses is pure
#ifndef LATTICED_CUDA_PLAN_FEATURE_USES_H_
#define LATTICED_CUDA_PLAN_FEATURE_USES_H_

#include <cstdint>
#include <vector>

#include "core/base/host_device.h"
#include "core/ffd/deform_plan.h"

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

// One a patch.
[[nodiscard]] std::vector<kernels::FeatureUses> PackFeatureUses(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_FEATURE_USES_H_
