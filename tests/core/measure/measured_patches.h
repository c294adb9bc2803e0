// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures of the deformed surface by quadrature of the definition on every patch.
#ifndef LATTICED_TESTS_CORE_MEASURE_MEASURED_PATCHES_H_
#define LATTICED_TESTS_CORE_MEASURE_MEASURED_PATCHES_H_

#include <span>

#include "core/ffd/direct_ffd.h"
#include "core/measure/triangle_rule.h"

namespace latticed::testing {

struct MeasuredPatches {
  double volume = 0, area = 0;
  Vec3d centroid;
};

// Exact but for rounding with m = 15: V has total degree 3 * 9 - 2, C one patch degree more.
inline MeasuredPatches MeasurePatches(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                      int m = 20) {
  const DirectFfd ffd(plan, control_points);
  const auto rule = MakeTriangleRule(m);
  const Vec3d origin = plan.local_origin;
  MeasuredPatches sum;
  Vec3d moment;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const auto corner = [&](size_t c) { return plan.vertices[plan.patches[p].vertex[c]].world; };
    const Vec3d area = 0.5 * Cross(corner(1) - corner(0), corner(2) - corner(0));
    for (const auto& point : rule) {
      const DeformedPoint at = ffd.EvaluatePosition(p, point.barycentrics);
      const Vec3d directed = point.weight * ApplyCofactor(at.jacobian, area);
      const Vec3d x = at.position - origin;
      sum.volume += Dot(x, directed) / 3;
      sum.area += Norm(directed);
      moment += 0.25 * Dot(x, directed) * x;
    }
  }
  sum.centroid = origin + moment / sum.volume;
  return sum;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_MEASURE_MEASURED_PATCHES_H_
