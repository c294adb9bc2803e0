// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares captured vertices with the definition, each at the exact coordinates that the
// tessellator gave it (comparator_precision.h).
//
//   aspect  longest edge^2 / (2 area) of the patch at rest: Pu x Pv of rounded control points loses
//           this factor of accuracy
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/statusor.h"
#include "core/ffd/plan/deform_plan.h"
#include "tests/bench/paper/comparator_precision.h"
#include "tests/bench/paper/shaders/shader_vertex.h"

namespace latticed::bench {

// Rounding moves control points by 2^-24 of the patch, differences of two by 2^-23, and tangents of
// degree n by n 2^-23. Two tangents at n = 6 give 1.4e-6. The sums add about the same.
inline constexpr double kShaderNormalError = 3e-6;

// Compares patches [first, first + count), three vertices per triangle. kInternal if patches are
// not in order, have different numbers of vertices, or are not covered once by their triangles.
[[nodiscard]] absl::StatusOr<ComparatorPrecision> CompareShaders(
    const DeformPlan& plan, std::span<const Vec3d> control_points, size_t first, size_t count,
    std::span<const ShaderVertex> vertices);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_
