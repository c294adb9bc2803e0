// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tessellation pattern of a patch: s segments per edge.
//
//   q = (s+1)(s+2)/2 points, s^2 triangles
//   rows r = 0..s of b2 = r/s; row r has s - r + 1 points; even rows run from corner 0 to corner 1,
//   odd rows back (serpentine). Triangles keep the winding of the patch's corners.
//
// Threads  TessellationPattern::Get returns one immutable pattern per s, made on first use
#ifndef LATTICED_CORE_FFD_TESSELLATION_PATTERN_H_
#define LATTICED_CORE_FFD_TESSELLATION_PATTERN_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/host_device.h"

namespace latticed {

LATTICED_HD constexpr int PointsPerPatch(int segments) {
  return (segments + 1) * (segments + 2) / 2;
}
LATTICED_HD constexpr int TrianglesPerPatch(int segments) { return segments * segments; }
// Index of the first point of row r.
LATTICED_HD constexpr int RowBegin(int segments, int row) {
  return row * (segments + 1) - row * (row - 1) / 2;
}
// Index of the point with b1 = column/s, b2 = row/s.
LATTICED_HD constexpr int PointIndex(int segments, int row, int column) {
  return RowBegin(segments, row) + (row % 2 == 0 ? column : segments - row - column);
}

// The k-th point, 0 … segments, of edge e, which runs from corner e to corner (e + 1) % 3.
LATTICED_HD constexpr int EdgePoint(int segments, int edge, int k) {
  if (edge == 0) return PointIndex(segments, 0, k);
  if (edge == 1) return PointIndex(segments, k, segments - k);
  return PointIndex(segments, segments - k, 0);
}

struct TessellationPattern {
  int segments = 0;
  // (i0, i1, i2), i0 + i1 + i2 = segments: barycentrics times segments, in point order.
  std::vector<std::array<uint8_t, 3>> points;
  std::vector<std::array<uint16_t, 3>> triangles;
  // EdgePoint(segments, e, 0 … segments).
  std::array<std::vector<uint16_t>, 3> edge_points;

  // segments in limits::kMinSegments … kMaxSegments.
  static const TessellationPattern& Get(int segments);
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_TESSELLATION_PATTERN_H_
