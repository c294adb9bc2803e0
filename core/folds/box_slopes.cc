// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/box_slopes.h"

#include <algorithm>
#include <cmath>

namespace latticed {
namespace {

// Replaces the points along an axis by as many sums of them.
void ApplyOnAxis(const BezierMatrix& matrix, size_t axis, BezierBox& grid) {
  constexpr size_t kMost = BezierBox::kMostPoints;
  constexpr std::array<size_t, 3> kStrides{1, kMost, kMost * kMost};
  const auto count = [&grid](size_t of) { return static_cast<size_t>(grid.degree[of]) + 1; };
  const size_t points = count(axis);
  const size_t a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
  for (size_t j = 0; j < count(b); ++j) {
    for (size_t i = 0; i < count(a); ++i) {
      Vec3d* const line = &grid.points[0][0][0] + i * kStrides[a] + j * kStrides[b];
      std::array<Vec3d, kMost> sums;
      for (size_t r = 0; r < points; ++r) {
        Vec3d sum;
        for (size_t s = 0; s < points; ++s) sum += matrix[r][s] * line[s * kStrides[axis]];
        sums[r] = sum;
      }
      for (size_t r = 0; r < points; ++r) line[r * kStrides[axis]] = sums[r];
    }
  }
}

}  // namespace

BoxPart WholeBox(const LatticeStructure& s, const std::array<int, 3>& span) {
  BoxPart part{.span = span, .lower = {}, .upper = {}};
  for (size_t a = 0; a < 3; ++a) {
    const auto first = static_cast<size_t>(span[a]);
    part.lower[static_cast<int>(a)] = s.knots[a][first];
    part.upper[static_cast<int>(a)] = s.knots[a][first + 1];
  }
  return part;
}

BezierBox ControlBox(const LatticeStructure& s, std::span<const Vec3d> control_points,
                     const std::array<int, 3>& span) {
  BezierBox box{.degree = s.degree};
  for (int k = 0; k <= s.degree[2]; ++k) {
    for (int j = 0; j <= s.degree[1]; ++j) {
      for (int i = 0; i <= s.degree[0]; ++i) {
        box.points[k][j][i] = control_points[static_cast<size_t>(s.Index(
            span[0] - s.degree[0] + i, span[1] - s.degree[1] + j, span[2] - s.degree[2] + k))];
      }
    }
  }
  return box;
}

double Differentiate(const LatticeStructure& s, const std::array<int, 3>& span, size_t axis,
                     BezierBox& grid) {
  const auto n = static_cast<size_t>(s.degree[axis]), k = static_cast<size_t>(span[axis]);
  const std::vector<double>& t = s.knots[axis];
  const std::array<int, 3> step{axis == 0, axis == 1, axis == 2};
  --grid.degree[axis];
  double most = 0;
  for (int w = 0; w <= grid.degree[2]; ++w) {
    for (int v = 0; v <= grid.degree[1]; ++v) {
      for (int u = 0; u <= grid.degree[0]; ++u) {
        const size_t first = k + 1 + static_cast<size_t>(axis == 0 ? u : axis == 1 ? v : w);
        const double scale =
            static_cast<double>(n) * ((t[k + 1] - t[k]) / (t[first] - t[first - n]));
        Vec3d& p = grid.points[w][v][u];
        p = scale * (grid.points[w + step[2]][v + step[1]][u + step[0]] - p);
        most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
    }
  }
  return most;
}

BoxSlopes::BoxSlopes(const LatticeStructure& s, std::span<const Vec3d> control_points,
                     const BoxPart& part)
    : structure_(s), span_(part.span), box_(ControlBox(s, control_points, part.span)) {
  for (size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    for (const int less : {0, 1}) {
      restrict_to_[static_cast<size_t>(less)][a] = BezierMatrixOf(
          s.knots[a], s.degree[a] - less, part.span[a], part.lower[axis], part.upper[axis]);
    }
  }
}

double BoxSlopes::Along(size_t axis, BezierBox& slopes) const {
  slopes = box_;
  const double most = Differentiate(structure_, span_, axis, slopes);
  for (size_t b = 0; b < 3; ++b) ApplyOnAxis(restrict_to_[axis == b ? 1 : 0][b], b, slopes);
  return most;
}

}  // namespace latticed
