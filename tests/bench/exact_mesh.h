// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes whose plan has a given number of patches. They stand for the paper's models, whose files
// are not available.
//
//   The mesh is the sample `knot`, a tube along a torus knot that spreads over the boxes, with its
//   quads cut in two, in a fitted lattice of 6 x 6 x 6 knot boxes. The resolution is about the
//   smallest that gives enough patches. Above the sample's largest resolution each triangle becomes
//   four. Then faces are removed, from the last on, until the plan has the number. A face's patches
//   do not depend on other faces, and most faces are one patch.
//   depend on other faces, and most faces are one patch.
//
// The lattice's structure stays that of the whole mesh, so all degrees split the mesh alike.
//
// Errors   kInternal if the plan of the remaining mesh has another number of patches
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_EXACT_MESH_H_
#define LATTICED_TESTS_BENCH_EXACT_MESH_H_

#include <array>
#include <cstddef>
#include <memory>

#include "absl/status/statusor.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed::bench {

inline constexpr int kBoxesPerAxis = 6;  // 216 knot boxes; 8 control points per axis at degree 2

// Cuts convex polygons into fans from their first corner. Drops attributes and groups.
[[nodiscard]] PolygonMesh Fans(const PolygonMesh& polygons);

// Cuts each triangle in four at the middles of its edges. Drops attributes and groups.
[[nodiscard]] PolygonMesh Subdivide(const PolygonMesh& triangles);

// Returns plan.mesh without the faces that bring `plan` above `patches`. kInternal if there are too
// few patches, or if no faces add up to the excess.
[[nodiscard]] absl::StatusOr<PolygonMesh> Trim(const DeformPlan& plan, size_t patches);

// A plan of exactly `patches` patches for control points of `degree`.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakeExactPlan(
    size_t patches, std::array<int, 3> degree);

// The same without trimming: at least `patches`, and at most a few percent more. For large numbers,
// where making two plans would take too long.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakeRoughPlan(
    size_t patches, std::array<int, 3> degree);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_EXACT_MESH_H_
