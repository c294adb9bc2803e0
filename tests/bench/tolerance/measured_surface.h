// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A surface that a view has evaluated: its size, and its distance from the exact one.
#ifndef LATTICED_TESTS_BENCH_TOLERANCE_MEASURED_SURFACE_H_
#define LATTICED_TESTS_BENCH_TOLERANCE_MEASURED_SURFACE_H_

#include <cstdint>

#include "core/backend.h"

namespace latticed::bench {

struct MeasuredSurface {
  size_t points = 0, triangles = 0;
  double diagonal = 0;       // of the points, world units
  double largest_error = 0;  // sampled at equal barycentrics, world units
};

// Reads all vertices of a view in kFloat32. Samples the middles of the triangles and of their sides of every
// `stride`-th patch, against the definition.
[[nodiscard]] MeasuredSurface MeasureSurface(DeformView& view, const DeformPlan& plan,
                                             std::span<const Vec3d> control_points, size_t stride);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TOLERANCE_MEASURED_SURFACE_H_
