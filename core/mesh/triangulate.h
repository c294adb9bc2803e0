// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Triangles of one polygon: ear clipping in the plane of best fit (Newell's normal).
//
//   triangles: n - 2 triples of local indices 0 … n - 1, in the polygon's winding; they replace the vector's contents
//
// Method    G. H. Meisters 1975, "Polygons have ears". A quadrilateral that both diagonals divide
//           takes the shorter one (0-2 on a tie). Only reflex corners can block an ear; they are
//           looked up in a k-d tree. A corner that is no ear is tried again when what blocks it has
//           gone. Corners bridged to a hole by a doubled edge are fine.
// Bad input a polygon that crosses itself or has no area still gives n - 2 triangles, which may
//           overlap or be empty; fewer than 3 corners give none. Coordinates must be finite.
// Errors    kInvalidArgument past kMaxTestsPerCorner, with a message that begins "it takes"; what `stop` returns. It
//           is asked once in some ten thousand tests.
// Threads   pure and deterministic
#ifndef LATTICED_CORE_MESH_TRIANGULATE_H_
#define LATTICED_CORE_MESH_TRIANGULATE_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"

namespace latticed {

// A polygon may take this many tests for each of its corners. A test compares a triangle with a corner, or with a node
// of the tree. Stars, combs and spirals of 65,536 corners take fewer than 400 per corner; 2,048 take about 2 s in all.
inline constexpr uint64_t kMaxTestsPerCorner = 2'048;

[[nodiscard]] absl::Status TriangulatePolygon(std::span<const Vec3d> polygon,
                                              std::vector<std::array<uint32_t, 3>>* triangles,
                                              StopCheck stop = NeverStop);

// Twice the vector area: the sum of cross products about the first corner. Its direction is the
// normal of the plane of best fit, its length twice the area of a planar polygon.
[[nodiscard]] Vec3d NewellNormal(std::span<const Vec3d> polygon);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_TRIANGULATE_H_
