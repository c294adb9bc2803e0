// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of a surface against those of samples of its definition.
#ifndef LATTICED_TESTS_CORE_MEASURE_CLOSE_BOUNDS_H_
#define LATTICED_TESTS_CORE_MEASURE_CLOSE_BOUNDS_H_

#include <span>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/pick/patch_tree.h"
#include "core/measure/surface_bounds.h"
#include "gtest/gtest.h"

namespace latticed::testing {

// The extremes of samples are inside, and come close: they miss by half of a curvature times the square of their spacing.
inline void ExpectCloseBounds(const DeformPlan& plan, std::span<const Vec3d> points) {
  const DirectFfd ffd(plan, points);
  Bounds sampled;
  constexpr int kSegments = 24;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (int i = 0; i <= kSegments; ++i) {
      for (int j = 0; i + j <= kSegments; ++j) {
        const double a = double(i) / kSegments, b = double(j) / kSegments;
        sampled.Extend(ffd.EvaluatePosition(p, {1 - a - b, a, b}).position);
      }
    }
  }

  const Bounds got = *MeasureBounds(plan, PatchTree(plan), points);

  for (int axis = 0; axis < 3; ++axis) {
    const double size = sampled.extent()[axis];
    EXPECT_GE(got.max[axis], sampled.max[axis] - 2e-9 * size);
    EXPECT_LE(got.min[axis], sampled.min[axis] + 2e-9 * size);
    EXPECT_LE(got.max[axis], sampled.max[axis] + 2e-3 * size);
    EXPECT_GE(got.min[axis], sampled.min[axis] - 2e-3 * size);
  }
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_MEASURE_CLOSE_BOUNDS_H_
