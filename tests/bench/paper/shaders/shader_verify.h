// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares captured vertices with the definition in double (core/ffd/direct_ffd.h), each at the very
// coordinates that the tessellator gave it.
//
//   position error  largest |p - definition| / diagonal of the deformed points
//   normal error    largest angle / (kappa aspect), kappa <= 100, aspect <= 1,000
//   aspect          longest edge^2 / (2 area) of the patch at rest: Pu x Pv of rounded control points
//                   loses as much, in the paper's own form, which has no frame for slivers
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/ffd/deform_plan.h"
#include "tests/bench/paper/shaders/shader_vertex.h"

namespace latticed::bench {

// That of the GEMM pipelines (verify.h).
inline constexpr double kShaderPositionError = 1e-6;
// Control points are off by 2^-24 of the patch, differences of two by 2^-23, tangents of degree n by
// n 2^-23, in each of two tangents: 1.4e-6 at n = 6; as much again for the sums.
inline constexpr double kShaderNormalError = 3e-6;

struct ShaderPrecision {
  double distance = 0;  // world units
  double normal = 0;
  Bounds deformed;             // of the points by the definition
  size_t distinct_points = 0;  // a patch: different coordinates

  double position() const { return distance / deformed.diagonal(); }
  void Include(const ShaderPrecision& other);
};

// Patches [first, first + count), three vertices a triangle. kInternal where patches do not follow
// each other, have unlike numbers of vertices, or are not covered once by their triangles.
[[nodiscard]] absl::StatusOr<ShaderPrecision> CompareShaders(
    const DeformPlan& plan, std::span<const Vec3d> control_points, size_t first, size_t count,
    std::span<const ShaderVertex> vertices);

// kInternal where one of the errors is larger than allowed.
[[nodiscard]] absl::Status CheckShaders(const ShaderPrecision& precision);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERIFY_H_
