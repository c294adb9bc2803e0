// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The weights of a plan in the form that the kernel reads: by group of patches, and by feature group
// (fused_layout.h). Empty for a plan without weights.
//
// Threads  immutable after FusedLayout has made it
#ifndef LATTICED_CORE_CPU_FUSED_FUSED_WEIGHTS_H_
#define LATTICED_CORE_CPU_FUSED_FUSED_WEIGHTS_H_

#include <cstdint>
#include <vector>

#include "core/cpu/fused/box_polynomials.h"
#include "core/cpu/fused/kernel/weight_lanes.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed::fused {

struct FusedWeights {
  std::vector<WeightedPatch> patches;  // one per group
  std::vector<EdgeWeights> edges;
  std::vector<CornerWeights> corners;

  // `along`, `across` and `shear` are the patch's in the world (fused_kernel.h), `facet` its unit normal.
  void PackPatch(const DeformPlan& plan, const BoxPolynomials& polynomials, size_t group,
                 size_t lane, uint32_t patch, Vec3d along, Vec3d across, double shear, Vec3d facet);
  void PackEdge(const DeformPlan& plan, uint32_t edge, uint32_t feature);
  void PackCorner(const DeformPlan& plan, uint32_t vertex, uint32_t feature);
  uint64_t MemoryBytes() const;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_FUSED_FUSED_WEIGHTS_H_
