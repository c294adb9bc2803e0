// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface that a client evaluates of a scene.
#ifndef LATTICED_TESTS_CLIENT_PATCHES_EVALUATED_SCENE_H_
#define LATTICED_TESTS_CLIENT_PATCHES_EVALUATED_SCENE_H_

#include <gtest/gtest.h>

#include <array>

#include "client/cpp/library/patches/patch_evaluator.h"
#include "core/adaptive/adaptive_pattern.h"
#include "tests/core/patches/patch_scene.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

inline client::PatchSurface EvaluateScene(const PatchScene& scene, double tolerance) {
  auto evaluator = client::PatchEvaluator::Create(scene.read, scene.plan->structure);
  EXPECT_OK(evaluator.status());
  client::PatchSurface surface;
  EXPECT_OK(evaluator->Evaluate(scene.control_points, scene.edge_bounds, tolerance, &surface));
  return surface;
}

inline const AdaptivePattern& PatternOf(const client::PatchSurface& surface, size_t patch) {
  return AdaptivePattern::Get(*PatternKey::FromCode(surface.patterns[patch]));
}

inline std::array<double, 3> Barycentrics(const AdaptivePattern& pattern, size_t point) {
  std::array<double, 3> b;
  for (size_t c = 0; c < 3; ++c) b[c] = double{1} * pattern.points[point][c] / pattern.denominator;
  return b;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_PATCHES_EVALUATED_SCENE_H_
