// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which seams of a DeformPlan are attached.
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

bool IsAttached(const DeformPlan& plan, const Seam& seam, std::span<const Vec3d> control_points) {
  if (seam.rests) return true;
  for (int k = seam.first[2]; k <= seam.last[2]; ++k) {
    for (int j = seam.first[1]; j <= seam.last[1]; ++j) {
      for (int i = seam.first[0]; i <= seam.last[0]; ++i) {
        const auto index = static_cast<size_t>(plan.structure.Index(i, j, k));
        if (control_points[index] != plan.identity_points[index]) return false;
      }
    }
  }
  return true;
}

std::vector<bool> AttachedSeams(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  std::vector<bool> attached(plan.seams.size());
  for (size_t s = 0; s < plan.seams.size(); ++s) {
    attached[s] = IsAttached(plan, plan.seams[s], control_points);
  }
  return attached;
}

}  // namespace latticed
