// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the vertices of the tensor-product comparator (tensor_product.h) with the definition.
// Each is looked up by its own (s, t) in the patches of its polygon (comparator_precision.h).
//
//   aspect  longer / shorter side of the parameter rectangle: rounding of control points costs the
//           tangent across this factor of accuracy
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/statusor.h"
#include "core/ffd/plan/deform_plan.h"
#include "tests/bench/paper/comparator_precision.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"

namespace latticed::bench {

// The largest error over all points of the paper's models is 1.4e-5. The bound by norms is
// 6 * 89^2 * 2^-24 = 3e-3: rows of inv(S) add up to 89, in two directions, and slopes have degree 6.
inline constexpr double kTensorNormalError = 4e-5;

// Compares every `stride`-th surface. `vertices` are those of all. kInternal if a vertex is not finite.
[[nodiscard]] absl::StatusOr<ComparatorPrecision> CompareTensor(
    const DeformPlan& plan, std::span<const Vec3d> control_points, const TensorSurfaces& surfaces,
    std::span<const TensorVertex> vertices, size_t stride);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_
