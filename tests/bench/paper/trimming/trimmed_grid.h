// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The part of a uniform grid over the unit square that lies in a convex polygon.
//
//   grid lines  s = i / segments, t = j / segments, i, j = 0 … segments
//   cells       inside the polygon a cell is kept whole. At the boundary it is clipped against the
//               polygon, and the remaining convex polygon is cut into a fan. Others are dropped
//   points      grid points, crossings of grid lines and sides, corners of the polygon; each once
//
// Threads  pure
#ifndef LATTICED_TESTS_BENCH_PAPER_TRIMMING_TRIMMED_GRID_H_
#define LATTICED_TESTS_BENCH_PAPER_TRIMMING_TRIMMED_GRID_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace latticed::bench {

struct TrimmedPoint {
  double s = 0, t = 0;
};

struct TrimmedGrid {
  std::vector<TrimmedPoint> points;  // sorted by t, then s, so the points of a line are adjacent
  std::vector<std::array<uint16_t, 3>> triangles;  // in the winding of the polygon
};

// `polygon` has its corners in the unit square. Points within 2^-40 of a grid line are moved onto it.
[[nodiscard]] TrimmedGrid TrimGrid(std::span<const TrimmedPoint> polygon, int segments);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TRIMMING_TRIMMED_GRID_H_
