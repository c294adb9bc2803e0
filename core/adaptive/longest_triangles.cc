// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/longest_triangles.h"

#include <algorithm>
#include <cstdlib>
#include <set>

namespace latticed {
namespace {

bool IsWithin(const std::array<double, 3>& side, const std::array<double, 3>& other) {
  return side[0] <= other[0] && side[1] <= other[1] && side[2] <= other[2];
}

bool IsWithin(const PatternSides& triangle, const PatternSides& other) {
  std::array<size_t, 3> order{0, 1, 2};
  do {
    if (IsWithin(triangle[0], other[order[0]]) && IsWithin(triangle[1], other[order[1]]) &&
        IsWithin(triangle[2], other[order[2]])) {
      return true;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return false;
}

PatternSides SidesOf(const SplitTriangle& t) {
  PatternSides sides;
  for (size_t s = 0; s < 3; ++s) {
    for (size_t a = 0; a < 3; ++a) {
      sides[s][a] = std::abs(t[(s + 1) % 3][a] - t[s][a]) / double{kSplitDenominator};
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

}  // namespace

std::vector<PatternSides> LongestTriangles(const std::vector<SplitTriangle>& triangles) {
  std::set<PatternSides> distinct;
  for (const SplitTriangle& t : triangles) distinct.insert(SidesOf(t));
  std::vector<PatternSides> longest;
  for (const PatternSides& candidate : distinct) {
    const bool is_within_another =
        std::any_of(distinct.begin(), distinct.end(), [&](const PatternSides& other) {
          return candidate != other && IsWithin(candidate, other);
        });
    if (!is_within_another) longest.push_back(candidate);
  }
  return longest;
}

}  // namespace latticed
