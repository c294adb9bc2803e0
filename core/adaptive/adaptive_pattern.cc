// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/adaptive_pattern.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "core/adaptive/longest_triangles.h"
#include "core/adaptive/pattern_split.h"

namespace latticed {
namespace {

// The least corner of a triangle, by (i_2, i_1), comes first.
SplitTriangle RotateToLeast(const SplitTriangle& t) {
  const auto order = [](const SplitPoint& p) { return std::pair(p[2], p[1]); };
  size_t first = 0;
  for (size_t c = 1; c < 3; ++c) {
    if (order(t[c]) < order(t[first])) first = c;
  }
  return {t[first], t[(first + 1) % 3], t[(first + 2) % 3]};
}

void SortTriangles(std::vector<SplitTriangle>& triangles) {
  for (SplitTriangle& t : triangles) t = RotateToLeast(t);
  std::sort(triangles.begin(), triangles.end(), [](const SplitTriangle& a, const SplitTriangle& b) {
    const auto order = [](const SplitTriangle& t) {
      return std::array{t[0][2], t[0][1], -t[1][2], -t[1][1]};
    };
    return order(a) < order(b);
  });
}

std::vector<SplitPoint> SerpentinePoints(const std::vector<SplitTriangle>& triangles, int rows) {
  std::map<int, std::vector<SplitPoint>> by_row;
  std::set<SplitPoint> seen;
  for (const SplitTriangle& t : triangles) {
    for (const SplitPoint& p : t) {
      if (seen.insert(p).second) by_row[p[2] * rows / kSplitDenominator].push_back(p);
    }
  }
  std::vector<SplitPoint> points;
  bool forward = true;
  for (auto& [row, in_row] : by_row) {
    std::sort(in_row.begin(), in_row.end(), [](const SplitPoint& a, const SplitPoint& b) {
      return std::pair(a[1], a[2]) < std::pair(b[1], b[2]);
    });
    if (!forward) std::reverse(in_row.begin(), in_row.end());
    points.insert(points.end(), in_row.begin(), in_row.end());
    forward = !forward;
  }
  return points;
}

// The largest power of two, up to kSplitDenominator, that divides every coordinate.
int CommonFactor(const std::vector<SplitPoint>& points) {
  uint32_t bits = kSplitDenominator;
  for (const SplitPoint& p : points) {
    bits |= static_cast<uint32_t>(p[0]) | static_cast<uint32_t>(p[1]) | static_cast<uint32_t>(p[2]);
  }
  return 1 << std::countr_zero(bits);
}

AdaptivePattern MakeAdaptivePattern(const PatternKey& key) {
  AdaptivePattern pattern{.key = key};
  std::vector<SplitTriangle> triangles = SplitPatch(key);
  SortTriangles(triangles);
  const int rows = 1 << *std::max_element(key.levels.begin(), key.levels.end());
  const std::vector<SplitPoint> points = SerpentinePoints(triangles, rows);
  const int factor = CommonFactor(points);
  pattern.denominator = kSplitDenominator / factor;
  std::map<SplitPoint, uint16_t> index;
  for (const SplitPoint& p : points) {
    index[p] = static_cast<uint16_t>(pattern.points.size());
    pattern.points.push_back({static_cast<uint16_t>(p[0] / factor),
                              static_cast<uint16_t>(p[1] / factor),
                              static_cast<uint16_t>(p[2] / factor)});
  }
  for (const SplitTriangle& t : triangles) {
    pattern.triangles.push_back({index.at(t[0]), index.at(t[1]), index.at(t[2])});
  }
  for (size_t e = 0; e < 3; ++e) {
    const int segment = kSplitDenominator >> key.levels[e];
    for (int along = 0; along <= kSplitDenominator; along += segment) {
      SplitPoint p{};
      p[e] = kSplitDenominator - along;
      p[(e + 1) % 3] = along;
      pattern.edge_points[e].push_back(index.at(p));
    }
  }
  pattern.longest = LongestTriangles(triangles);
  return pattern;
}

}  // namespace

const AdaptivePattern& AdaptivePattern::Get(const PatternKey& key) {
  constexpr size_t kCodes = size_t{1} << kPatternCodeBits;
  static std::array<std::once_flag, kCodes> once;
  // Never destroyed: threads may still use them when the program ends.
  static std::array<std::atomic<const AdaptivePattern*>, kCodes> patterns;
  const size_t code = key.Code();
  // A call_once for each patch would take 3 % of an evaluation.
  if (const AdaptivePattern* made = patterns[code].load(std::memory_order_acquire)) return *made;
  std::call_once(once[code], [&] {
    patterns[code].store(new AdaptivePattern(MakeAdaptivePattern(key)), std::memory_order_release);
  });
  return *patterns[code].load(std::memory_order_acquire);
}

}  // namespace latticed
