// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How far an evaluated surface is from the definition in double.
#ifndef LATTICED_TESTS_CLIENT_PATCHES_SURFACE_ERROR_H_
#define LATTICED_TESTS_CLIENT_PATCHES_SURFACE_ERROR_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/quantisation_box.h"
#include "tests/client/patches/evaluated_scene.h"
#include "tests/support/definition.h"

namespace latticed::testing {

// Octahedral integers of 16 bits turn a rest normal by 4e-5, int16 components by 3e-5. A place off by half a unit turns
// the Jacobian of a strongly bent box by as much again. Both count kappa times. Measured: up to 1.4e-4.
inline constexpr double kNormalTolerance = 2e-4;

// What is worst in a surface, in units of what is allowed.
struct Worst {
  double position = 0, normal = 0;
  size_t points = 0;
};

// Half a unit of 16 bits around the deformed surface, and 1e-6 of its diagonal, on each axis.
inline Worst Compare(const PatchScene& scene, const client::PatchSurface& surface) {
  const DeformPlan& plan = *scene.plan;
  const RestNormals normals = scene.read->header.normals;
  const DirectFfd direct(plan, scene.control_points);
  Bounds bounds;
  std::vector<Vec3d> expected;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (size_t i = 0; i < PatternOf(surface, p).points.size(); ++i) {
      expected.push_back(
          direct.EvaluatePosition(p, Barycentrics(PatternOf(surface, p), i)).position);
      bounds.Extend(expected.back());
    }
  }
  const double unit = FitQuantisationBox(bounds, 1).step(16);
  const double allowed = 0.5 * unit + 1e-6 * bounds.diagonal();
  Worst worst{.points = expected.size()};
  EXPECT_EQ(surface.positions.size(), expected.size());
  EXPECT_EQ(surface.normals.size(), normals == RestNormals::kNone ? 0 : expected.size());
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (size_t i = surface.first_points[p]; i < surface.first_points[p + 1]; ++i) {
      const Vec3d off = ToDouble(surface.positions[i]) + plan.local_origin - expected[i];
      for (int a = 0; a < 3; ++a)
        worst.position = std::max(worst.position, std::abs(off[a]) / allowed);
      if (normals == RestNormals::kNone) continue;
      const auto kind =
          normals == RestNormals::kFacet ? DirectFfd::Normal::kFacet : DirectFfd::Normal::kSmooth;
      const auto point = direct.Evaluate(
          p, Barycentrics(PatternOf(surface, p), i - surface.first_points[p]), kind);
      const Vec3d normal = ToDouble(surface.normals[i]);
      if (point.substituted || point.kappa > kMostKappa) continue;
      EXPECT_NEAR(Norm(normal), 1, kUnitTolerance) << "patch " << p;
      worst.normal = std::max(worst.normal, Angle(normal, point.normal) / point.kappa);
    }
  }
  return worst;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_PATCHES_SURFACE_ERROR_H_
