// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tessellation pattern of a patch whose edges have different levels. core/adaptive/pattern_split.h has the rule of
// its triangles. This is the rule of their order.
//
//   denominator   the least power of two over which all points are integers
//   points        by rows, serpentine. With K the largest level, a point is in row floor(i_2 2^K / denominator). Rows
//                 without points do not count. Even rows run by ascending (i_1, i_2), odd rows by descending
//   triangles     keep the winding of the patch, and begin with their least corner by (i_2, i_1). They are sorted by
//                 that corner, ascending, then by their second corner, descending
//
// Levels (k, k, k) give the points, triangles and edge points of TessellationPattern::Get(2^k), in its order; the
// sparser pattern is then the same. Between rows, neighbours in the list are neighbours on the patch, so that codes of
// differences are small.
//
// Threads  Get returns one immutable pattern per key, made on first use; finding it later takes no lock
#ifndef LATTICED_CORE_ADAPTIVE_ADAPTIVE_PATTERN_H_
#define LATTICED_CORE_ADAPTIVE_ADAPTIVE_PATTERN_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/adaptive/pattern_key.h"

namespace latticed {

// Of any pattern. 32 patches have at most 38,176 points, which is below limits::kMaxChunkPoints.
inline constexpr int kMaxPatternPoints = 1'193;
inline constexpr int kMaxPatternTriangles = 2'304;

// The sides of a triangle of a pattern: the absolute differences of their ends' barycentrics.
using PatternSides = std::array<std::array<double, 3>, 3>;

struct AdaptivePattern {
  PatternKey key;
  int denominator = 1;  // 1 … 4096
  // Barycentrics times the denominator.
  std::vector<std::array<uint16_t, 3>> points;
  std::vector<std::array<uint16_t, 3>> triangles;
  // edge_points[e][0 … 2^levels[e]]: from corner e to corner (e + 1) % 3.
  std::array<std::vector<uint16_t>, 3> edge_points;
  // What a certificate looks at: the triangles of the pattern, without those of which each side is in no component
  // longer than a side of one other triangle. At most 33.
  std::vector<PatternSides> longest;

  // Every level is 0 … limits::kMaxEdgeLevel.
  static const AdaptivePattern& Get(const PatternKey& key);
};

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_ADAPTIVE_PATTERN_H_
