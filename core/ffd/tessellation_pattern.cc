// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/tessellation_pattern.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "core/base/limits.h"

namespace latticed {
namespace {

TessellationPattern MakePattern(int s) {
  TessellationPattern pattern;
  pattern.segments = s;
  const auto index = [s](int row, int column) {
    return static_cast<uint16_t>(PointIndex(s, row, column));
  };
  pattern.points.resize(static_cast<size_t>(PointsPerPatch(s)));
  for (int row = 0; row <= s; ++row) {
    for (int column = 0; column <= s - row; ++column) {
      pattern.points[index(row, column)] = {static_cast<uint8_t>(s - row - column),
                                            static_cast<uint8_t>(column),
                                            static_cast<uint8_t>(row)};
    }
  }
  pattern.triangles.reserve(static_cast<size_t>(TrianglesPerPatch(s)));
  for (int row = 0; row < s; ++row) {
    for (int column = 0; column < s - row; ++column) {
      pattern.triangles.push_back(
          {index(row, column), index(row, column + 1), index(row + 1, column)});
      if (column + 1 < s - row) {
        pattern.triangles.push_back(
            {index(row, column + 1), index(row + 1, column + 1), index(row + 1, column)});
      }
    }
  }
  for (int edge = 0; edge < 3; ++edge) {
    for (int k = 0; k <= s; ++k) {
      pattern.edge_points[static_cast<size_t>(edge)].push_back(
          static_cast<uint16_t>(EdgePoint(s, edge, k)));
    }
  }
  return pattern;
}

}  // namespace

const TessellationPattern& TessellationPattern::Get(int segments) {
  static std::array<std::once_flag, limits::kMaxSegments + 1> once;
  // Never destroyed: threads may still use them when the program ends.
  static auto& patterns =
      *new std::array<std::unique_ptr<const TessellationPattern>, limits::kMaxSegments + 1>;
  const auto s =
      static_cast<size_t>(std::clamp(segments, limits::kMinSegments, limits::kMaxSegments));
  std::call_once(once[s], [s] {
    patterns[s] = std::make_unique<const TessellationPattern>(MakePattern(static_cast<int>(s)));
  });
  return *patterns[s];
}

}  // namespace latticed
