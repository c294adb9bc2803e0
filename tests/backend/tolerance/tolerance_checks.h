// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every view with a tolerance, with and without vertex weights.
#ifndef LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_CHECKS_H_
#define LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_CHECKS_H_

#include <random>
#include <span>

#include "core/adaptive/adaptive_pattern.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {

[[nodiscard]] const AdaptivePattern& PatternOf(uint16_t code);

// Counts the places at vertices and edges where the points of two patches differ, or where edges have other levels.
[[nodiscard]] size_t CountCracksBetween(const DeformPlan& plan,
                                        std::span<const Vec3d> control_points,
                                        std::span<const uint16_t> codes,
                                        std::span<const ViewPoint> points);

// The largest distance, at equal barycentrics, between a random point of a triangle and the exact surface.
[[nodiscard]] double LargestDistance(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                     std::span<const uint16_t> codes,
                                     std::span<const ViewPoint> points, std::mt19937& random);

// At each point of each pattern: the position is within the point error, the normal as tests/support/definition.h says.
void ExpectPointsOfTheDefinition(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                 const ViewSpec& spec, const QuantisationBox& box,
                                 std::span<const uint16_t> codes,
                                 std::span<const ViewPoint> points);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_CHECKS_H_
