// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a convex polygon leaves of a uniform grid over the unit square.
//
//   grid lines  s = i / segments, t = j / segments, i, j = 0 … segments
//   a cell      inside the polygon is kept whole; across its boundary it is clipped against it, and
//               what remains, a convex polygon too, is cut into a fan; outside it is dropped
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
  std::vector<TrimmedPoint> points;  // by t, then s: those of a line follow each other
  std::vector<std::array<uint16_t, 3>> triangles;  // in the winding of the polygon
};

// Of corners in the unit square. What is within 2^-40 of a grid line is on it.
[[nodiscard]] TrimmedGrid TrimGrid(std::span<const TrimmedPoint> polygon, int segments);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TRIMMING_TRIMMED_GRID_H_
