// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Triangulates a small convex polygon so that its worst triangle is as good as possible.
//
//   quality of a triangle = |cross product of two sides| / (longest side)^2, 0 for no area
//
// Cutting leaves several vertices on one straight side, where a fan or ear clipping would make triangles without area.
// This method makes such a triangle only where every triangulation has one. It is Klincsek's dynamic programme, O(n^3)
// for n corners; most polygons have three or four.
//
// Threads  pure function
#ifndef LATTICED_CORE_FFD_PLAN_CONVEX_TRIANGULATION_H_
#define LATTICED_CORE_FFD_PLAN_CONVEX_TRIANGULATION_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/vec.h"

namespace latticed {

inline double TriangleQuality(Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, bc = c - b, ca = a - c;
  const double longest = std::max({Dot(ab, ab), Dot(bc, bc), Dot(ca, ca)});
  const Vec3d normal = Cross(ab, c - a);
  return longest > 0 ? std::sqrt(Dot(normal, normal)) / longest : 0.0;
}

// Calls emit(a, b, c) for each of the points.size() - 2 triangles, a < b < c. There are 3 points or more.
// A triangle cut by three slabs has at most 9 corners, and rounding may add a few collinear ones. Each turned lattice that cuts
// the same triangle on both sides along all axes adds 6. Above 32, a fan is made.
template <typename Emit>
void TriangulateConvex(std::span<const Vec3d> points, Emit&& emit) {
  const size_t n = points.size();
  if (n == 3) return emit(size_t{0}, size_t{1}, size_t{2});
  constexpr size_t kMost = 32;
  if (n > kMost) {  // hardly ever; a fan keeps the topology
    for (size_t k = 1; k + 1 < n; ++k) emit(size_t{0}, k, k + 1);
    return;
  }
  // worst[i][j]: quality of the worst triangle in the best triangulation of corners i … j.
  std::array<std::array<double, kMost>, kMost> worst;
  std::array<std::array<uint8_t, kMost>, kMost> apex{};
  for (size_t i = 0; i + 1 < n; ++i) worst[i][i + 1] = HUGE_VAL;
  for (size_t length = 2; length < n; ++length) {
    for (size_t i = 0; i + length < n; ++i) {
      const size_t j = i + length;
      worst[i][j] = -1;
      for (size_t k = i + 1; k < j; ++k) {
        const double quality =
            std::min({worst[i][k], worst[k][j], TriangleQuality(points[i], points[k], points[j])});
        if (quality > worst[i][j]) {
          worst[i][j] = quality;
          apex[i][j] = static_cast<uint8_t>(k);
        }
      }
    }
  }
  const auto descend = [&](auto&& self, size_t i, size_t j) -> void {
    if (j < i + 2) return;
    const size_t k = apex[i][j];
    self(self, i, k);
    emit(i, k, j);
    self(self, k, j);
  };
  descend(descend, 0, n - 1);
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_CONVEX_TRIANGULATION_H_
