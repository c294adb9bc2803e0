// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Triangles of one polygon: ear clipping in the plane of best fit (Newell's normal).
//
//   triangles: n - 2 triples of local indices 0 … n - 1, in the polygon's winding; they replace the vector's contents
//
// Method    G. H. Meisters 1975, "Polygons have ears". A quadrilateral that both diagonals divide
//           takes the shorter one (0-2 on a tie). Only reflex corners can block an ear; polygons of
//           many corners look them up in a grid. Corners bridged to a hole by a doubled edge
//           are fine.
// Bad input a polygon that crosses itself or has no area still gives n - 2 triangles, which may
//           overlap or be empty; fewer than 3 corners give none. Coordinates must be finite.
// Threads   pure and deterministic.
#ifndef LATTICED_CORE_MESH_TRIANGULATE_H_
#define LATTICED_CORE_MESH_TRIANGULATE_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

void TriangulatePolygon(std::span<const Vec3d> polygon,
                        std::vector<std::array<uint32_t, 3>>* triangles);

// Twice the vector area: the sum of cross products about the first corner. Its direction is the
// normal of the plane of best fit, its length twice the area of a planar polygon.
[[nodiscard]] Vec3d NewellNormal(std::span<const Vec3d> polygon);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_TRIANGULATE_H_
