// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan's patches as the device reads them.
//
// Errors   kResourceExhausted beyond what device_patch.h has bits for
// Threads  pure
#ifndef LATTICED_CUDA_PLAN_PACK_PATCHES_H_
#define LATTICED_CUDA_PLAN_PACK_PATCHES_H_

#include <array>
#include <vector>

#include "absl/status/statusor.h"
#include "core/ffd/plan/deform_plan.h"
#include "cuda/plan/device_patch.h"

namespace latticed {

struct PackedPatches {
  std::vector<kernels::DevicePatch> patches;
  std::vector<kernels::SeamUse> seam_uses;
};
[[nodiscard]] absl::StatusOr<PackedPatches> PackPatches(const DeformPlan& plan);

// By axis: the difference of the numbers of two boxes that are neighbours along it.
[[nodiscard]] std::array<uint32_t, 3> BoxStrides(const LatticeStructure& structure);

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_PACK_PATCHES_H_
