// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surfaces of a plan and their trimmed points, for the tensor-product comparator
// (tensor_product.h). Made once on the host in double, then rounded.
//
// Errors   those of sub_polygons.h; kUnimplemented if the patches are not of degree 6
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"
#include "tests/bench/paper/tensor/tensor_product.h"
#include "tests/bench/paper/trimming/parameter_rectangle.h"
#include "tests/bench/paper/trimming/sub_polygons.h"

namespace latticed::bench {

struct TensorSurfaces {
  std::vector<SubPolygon> polygons;     // one per surface
  std::vector<TensorSurface> surfaces;  // plus an end of lines and points
  std::vector<TensorLine> lines;
  std::vector<TensorPoint> points;
  size_t triangles = 0;   // in all trimmed grids
  size_t most_lines = 0;  // largest number in a group

  size_t count() const { return polygons.size(); }
};

[[nodiscard]] absl::StatusOr<TensorSurfaces> MakeTensorSurfaces(const DeformPlan& plan);

// In the world. `normal` is that of the polygon's plane.
[[nodiscard]] ParameterRectangle RectangleOf(const DeformPlan& plan, const SubPolygon& polygon,
                                             Vec3d normal);

[[nodiscard]] TensorInverse MakeTensorInverse();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_
