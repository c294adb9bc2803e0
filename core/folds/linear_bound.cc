// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/linear_bound.h"

#include "core/base/bounds.h"

namespace latticed {

LinearBound BoundLinearly(const BezierBox& box) {
  LinearBound bound;
  const auto node = [&](size_t axis, int i) {
    return box.degree[axis] == 0 ? 0 : 2.0 * i / box.degree[axis] - 1;
  };
  const auto for_each = [&](auto visit) {
    for (int k = 0; k <= box.degree[2]; ++k) {
      for (int j = 0; j <= box.degree[1]; ++j) {
        for (int i = 0; i <= box.degree[0]; ++i) {
          visit(box.points[k][j][i], Vec3d{node(0, i), node(1, j), node(2, k)});
        }
      }
    }
  };
  double count = 0;
  Vec3d squares;
  for_each([&](Vec3d p, Vec3d y) {
    count += 1;
    bound.centre += p;
    for (size_t b = 0; b < 3; ++b) {
      const double at = y[static_cast<int>(b)];
      bound.slope[b] += at * p;
      squares[static_cast<int>(b)] += at * at;
    }
  });
  bound.centre = bound.centre / count;
  for (size_t b = 0; b < 3; ++b) {
    const double square = squares[static_cast<int>(b)];
    bound.slope[b] = square > 0 ? bound.slope[b] / square : Vec3d{};
  }
  Bounds beside;
  for_each([&](Vec3d p, Vec3d y) {
    beside.Extend(
        p - (bound.centre + y.x * bound.slope[0] + y.y * bound.slope[1] + y.z * bound.slope[2]));
  });
  bound.centre += beside.center();
  bound.radius = 0.5 * beside.extent();
  return bound;
}

}  // namespace latticed
