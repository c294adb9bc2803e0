// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rectangle in the plane of a convex polygon over which its tensor-product surface is defined:
// the one of least area that holds the polygon. It has a side along a side of the polygon. Where
// several are as small, as for an acute triangle, it is the one nearest to a square.
//                                      Freeman & Shapira 1975, doi:10.1145/360881.360919
//
// How Cui & Feng 2013 turn their rectangle is not known here. A smaller one has its samples nearer
// to the knot box, and drops fewer cells.
//
//   x = corner + s along + t across,  s, t in [0, 1];  along x across points along the normal
//
// Units    the corners are in the world
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TRIMMING_PARAMETER_RECTANGLE_H_
#define LATTICED_TESTS_BENCH_PAPER_TRIMMING_PARAMETER_RECTANGLE_H_

#include <span>
#include <vector>

#include "core/base/vec.h"
#include "tests/bench/paper/trimming/trimmed_grid.h"

namespace latticed::bench {

struct ParameterRectangle {
  Vec3d corner, along, across;
  std::vector<TrimmedPoint> polygon;  // the corners, in [0, 1]²
};

// `corners` are in their winding around the unit `normal`. A polygon without area has a rectangle
// without area, with 0 for coordinates that have no meaning.
[[nodiscard]] ParameterRectangle SmallestRectangle(std::span<const Vec3d> corners, Vec3d normal);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TRIMMING_PARAMETER_RECTANGLE_H_
