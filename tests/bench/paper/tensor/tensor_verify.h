// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the vertices of the tensor-product comparator (tensor_product.h) with the definition, each
// at its own (s, t), found again in the patches of its polygon (comparator_precision.h).
//
//   aspect  longer side of the parameter rectangle / the shorter one: rounded control points take as
//           much from the tangent across
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_

#include <cstddef>
#include <span>

#include "absl/status/statusor.h"
#include "core/ffd/deform_plan.h"
#include "tests/bench/paper/comparator_precision.h"
#include "tests/bench/paper/tensor/tensor_surfaces.h"

namespace latticed::bench {

// Of all points of the paper's models the largest is 1.4e-5. By norms alone, rows of inv(S) that add
// up to 89 in two directions and slopes of degree 6, it could be 6 * 89^2 * 2^-24, 3e-3.
inline constexpr double kTensorNormalError = 4e-5;

// Every `stride`-th surface; `vertices` are those of all. kInternal where one is no number.
[[nodiscard]] absl::StatusOr<ComparatorPrecision> CompareTensor(
    const DeformPlan& plan, std::span<const Vec3d> control_points, const TensorSurfaces& surfaces,
    std::span<const TensorVertex> vertices, size_t stride);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_VERIFY_H_
