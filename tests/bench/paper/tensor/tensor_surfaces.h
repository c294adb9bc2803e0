// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the tensor-product comparator (tensor_product.h) keeps of a plan: surfaces, and where their
// trimmed points are. Made on the host in double, once, then rounded.
//
// Errors   those of sub_polygons.h; kUnimplemented for patches that are not of degree 6
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/deform_plan.h"
#include "tests/bench/paper/tensor/tensor_product.h"
#include "tests/bench/paper/trimming/parameter_rectangle.h"
#include "tests/bench/paper/trimming/sub_polygons.h"

namespace latticed::bench {

struct TensorSurfaces {
  std::vector<SubPolygon> polygons;     // one a surface
  std::vector<TensorSurface> surfaces;  // and where the last one's lines and points end
  std::vector<TensorLine> lines;
  std::vector<TensorPoint> points;
  size_t triangles = 0;   // of all trimmed grids
  size_t most_lines = 0;  // of a group

  size_t count() const { return polygons.size(); }
};

[[nodiscard]] absl::StatusOr<TensorSurfaces> MakeTensorSurfaces(const DeformPlan& plan);

// In the world; `normal` is that of the polygon's plane.
[[nodiscard]] ParameterRectangle RectangleOf(const DeformPlan& plan, const SubPolygon& polygon,
                                             Vec3d normal);

[[nodiscard]] TensorInverse MakeTensorInverse();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_SURFACES_H_
