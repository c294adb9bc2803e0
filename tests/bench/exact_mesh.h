// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes whose plan has as many patches as one wants: those of the paper's models, whose files
// nobody has.
//
//   The sample mesh `knot` (a tube along a torus knot, which spreads over the boxes), its quads cut
//   in two, in a lattice of 6 x 6 x 6 knot boxes fitted to it, at the least resolution that gives
//   enough patches; above the sample's largest resolution each triangle becomes four. Then faces go
//   from the end of the list until the plan has the number asked for: a face's patches do not
//   depend on other faces, and most faces are one patch.
//
// The lattice's structure stays that of the whole mesh, so that all degrees split it alike.
//
// Errors   kInternal where the plan of what is left has another number
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_EXACT_MESH_H_
#define LATTICED_TESTS_BENCH_EXACT_MESH_H_

#include <array>
#include <cstddef>
#include <memory>

#include "absl/status/statusor.h"
#include "core/ffd/deform_plan.h"

namespace latticed::bench {

inline constexpr int kBoxesPerAxis = 6;  // 216 knot boxes; 8 control points an axis at degree 2

// Polygons as fans from their first corner: for convex ones. Attributes and groups are dropped.
[[nodiscard]] PolygonMesh Fans(const PolygonMesh& polygons);

// Each triangle in four, at the middles of its edges; the same is dropped.
[[nodiscard]] PolygonMesh Subdivide(const PolygonMesh& triangles);

// `mesh` without the faces that bring `plan` of it above `patches`. Not enough patches, or faces
// that do not add up: kInternal.
[[nodiscard]] absl::StatusOr<PolygonMesh> Trim(const DeformPlan& plan, size_t patches);

// A plan of exactly `patches` patches for control points of `degree`.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakeExactPlan(
    size_t patches, std::array<int, 3> degree);

// The same without trimming, at least `patches` and at most a few percent more: for large numbers,
// of which one plan takes long enough.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakeRoughPlan(
    size_t patches, std::array<int, 3> degree);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_EXACT_MESH_H_
