// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box/bezier_box.h"

namespace latticed {
namespace {

constexpr size_t kMost = BezierBox::kMostPoints;
using Row = std::array<double, kMost>;

// The polar form of each basis function: the recurrence of EvaluateBasis, with another argument at each level.
Row PolarForm(const double* knots, int degree, int span, const double* arguments) {
  Row values{1};
  for (int j = 1; j <= degree; ++j) {
    const double u = arguments[j - 1];
    double saved = 0;
    for (int r = 0; r < j; ++r) {
      const double right = knots[span + r + 1] - u, left = u - knots[span + 1 - j + r];
      const double term =
          values[static_cast<size_t>(r)] / (knots[span + r + 1] - knots[span + 1 - j + r]);
      values[static_cast<size_t>(r)] = saved + right * term;
      saved = left * term;
    }
    values[static_cast<size_t>(j)] = saved;
  }
  return values;
}

struct Extent {
  std::array<size_t, 3> count{};
  std::array<int, 3> first{};
};
Extent ExtentOf(const LatticeStructure& s, const std::array<int, 3>& span) {
  Extent extent;
  for (size_t a = 0; a < 3; ++a) {
    extent.count[a] = static_cast<size_t>(s.degree[a]) + 1;
    extent.first[a] = span[a] - s.degree[a];
  }
  return extent;
}

}  // namespace

BezierMatrix BezierMatrixOf(std::span<const double> knots, int degree, int span, double lower,
                            double upper) {
  BezierMatrix matrix{};
  double arguments[limits::kMaxDegree] = {lower, lower, lower};
  for (int i = 0; i <= degree; ++i) {
    if (i > 0) arguments[i - 1] = upper;
    matrix[static_cast<size_t>(i)] = PolarForm(knots.data(), degree, span, arguments);
  }
  return matrix;
}

Bounds BezierBox::Hull() const {
  Bounds hull;
  for (int k = 0; k <= degree[2]; ++k) {
    for (int j = 0; j <= degree[1]; ++j) {
      for (int i = 0; i <= degree[0]; ++i) hull.Extend(points[k][j][i]);
    }
  }
  return hull;
}

Bounds BezierBox::SlopeHull(size_t axis) const {
  const std::array<int, 3> step{axis == 0, axis == 1, axis == 2};
  Bounds hull;
  for (int k = 0; k + step[2] <= degree[2]; ++k) {
    for (int j = 0; j + step[1] <= degree[1]; ++j) {
      for (int i = 0; i + step[0] <= degree[0]; ++i) {
        hull.Extend(degree[axis] *
                    (points[k + step[2]][j + step[1]][i + step[0]] - points[k][j][i]));
      }
    }
  }
  return hull;
}

BezierBox RestrictVolume(const LatticeStructure& s, std::span<const Vec3d> control_points,
                         const std::array<int, 3>& span, Vec3d lower, Vec3d upper) {
  std::array<BezierMatrix, 3> to_bezier;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    to_bezier[a] = BezierMatrixOf(s.knots[a], s.degree[a], span[a], lower[axis], upper[axis]);
  }
  const Extent extent = ExtentOf(s, span);
  const auto& [nu, nv, nw] = extent.count;
  BezierBox box{.degree = s.degree};
  Vec3d along_u[kMost][kMost][kMost], along_v[kMost][kMost][kMost];
  for (size_t k = 0; k < nw; ++k) {
    for (size_t j = 0; j < nv; ++j) {
      const Vec3d* row =
          control_points.data() + s.Index(extent.first[0], extent.first[1] + static_cast<int>(j),
                                          extent.first[2] + static_cast<int>(k));
      for (size_t i = 0; i < nu; ++i) {
        for (size_t r = 0; r < nu; ++r) along_u[k][j][i] += to_bezier[0][i][r] * row[r];
      }
    }
  }
  for (size_t k = 0; k < nw; ++k) {
    for (size_t j = 0; j < nv; ++j) {
      for (size_t r = 0; r < nv; ++r) {
        for (size_t i = 0; i < nu; ++i) along_v[k][j][i] += to_bezier[1][j][r] * along_u[k][r][i];
      }
    }
  }
  for (size_t k = 0; k < nw; ++k) {
    for (size_t r = 0; r < nw; ++r) {
      for (size_t j = 0; j < nv; ++j) {
        for (size_t i = 0; i < nu; ++i) {
          box.points[k][j][i] += to_bezier[2][k][r] * along_v[r][j][i];
        }
      }
    }
  }
  return box;
}

Bounds ControlHull(const LatticeStructure& s, std::span<const Vec3d> control_points,
                   const std::array<int, 3>& span) {
  const Extent extent = ExtentOf(s, span);
  Bounds hull;
  for (size_t k = 0; k < extent.count[2]; ++k) {
    for (size_t j = 0; j < extent.count[1]; ++j) {
      const Vec3d* row =
          control_points.data() + s.Index(extent.first[0], extent.first[1] + static_cast<int>(j),
                                          extent.first[2] + static_cast<int>(k));
      for (size_t i = 0; i < extent.count[0]; ++i) hull.Extend(row[i]);
    }
  }
  return hull;
}

}  // namespace latticed
