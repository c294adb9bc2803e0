// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/box_determinant.h"

#include <algorithm>
#include <cmath>

#include "core/ffd/box/bezier_box.h"

namespace latticed {
namespace {

constexpr size_t kMostProductCount = BernsteinVolume::kMostCount;
constexpr double kDeterminantSlack = 6 * (450 + 8 * kMostHalvings) * 0x1p-53;

constexpr auto kProductBinomials = [] {
  std::array<std::array<double, kMostProductCount>, kMostProductCount> b{};
  for (size_t n = 0; n < kMostProductCount; ++n) {
    b[n][0] = 1;
    for (size_t k = 1; k <= n; ++k) b[n][k] = b[n - 1][k - 1] + (k < n ? b[n - 1][k] : 0);
  }
  return b;
}();

// SpreadVectors over a grid of coefficients, with the strides of the result. A product of polynomials is then one sum of
// products of flat arrays: gaps between rows hold zeros.
struct SpreadVectors {
  std::array<size_t, 3> count{};
  std::array<std::array<double, BernsteinVolume::kMostCoefficients>, 3> c;

  // The numbers from the first to the last one of a layer.
  size_t LayerRun(size_t row) const { return row * (count[1] - 1) + count[0]; }
};

// Puts the coefficients, times their binomials, at the strides of the result.
void SpreadInto(const BezierBox& box, size_t row, size_t layer, SpreadVectors& to) {
  for (size_t a = 0; a < 3; ++a) to.count[a] = static_cast<size_t>(box.degree[a]) + 1;
  const std::array<size_t, 3> n = to.count;
  const size_t size = layer * (n[2] - 1) + to.LayerRun(row);
  for (auto& component : to.c) std::fill_n(component.begin(), size, 0.0);
  for (size_t k = 0; k < n[2]; ++k) {
    for (size_t j = 0; j < n[1]; ++j) {
      const double weight = kProductBinomials[n[2] - 1][k] * kProductBinomials[n[1] - 1][j];
      for (size_t i = 0; i < n[0]; ++i) {
        const Vec3d p = weight * kProductBinomials[n[0] - 1][i] * box.points[k][j][i];
        const size_t index = i + row * j + layer * k;
        to.c[0][index] = p.x;
        to.c[1][index] = p.y;
        to.c[2][index] = p.z;
      }
    }
  }
}

void AddCross(Vec3d a, const SpreadVectors& b, size_t from, SpreadVectors& product, size_t to,
              size_t run) {
  const double* __restrict bx = &b.c[0][from], * __restrict by = &b.c[1][from], * __restrict bz = &b.c[2][from];
  double *__restrict x = &product.c[0][to], *__restrict y = &product.c[1][to],
                     *__restrict z = &product.c[2][to];
  for (size_t i = 0; i < run; ++i) {
    x[i] += a.y * bz[i] - a.z * by[i];
    y[i] += a.z * bx[i] - a.x * bz[i];
    z[i] += a.x * by[i] - a.y * bx[i];
  }
}

void AddDot(Vec3d a, const SpreadVectors& b, size_t from, double* __restrict sum, size_t run) {
  const double* __restrict bx = &b.c[0][from], * __restrict by = &b.c[1][from], * __restrict bz = &b.c[2][from];
  for (size_t i = 0; i < run; ++i) sum[i] += a.x * bx[i] + a.y * by[i] + a.z * bz[i];
}

// Calls visit(coefficient, its place) for each of the coefficients.
template <typename Visit>
void ForEachVector(const SpreadVectors& vectors, size_t row, size_t layer, Visit visit) {
  for (size_t k = 0; k < vectors.count[2]; ++k) {
    for (size_t j = 0; j < vectors.count[1]; ++j) {
      for (size_t i = 0; i < vectors.count[0]; ++i) {
        const size_t at = i + row * j + layer * k;
        visit(Vec3d{vectors.c[0][at], vectors.c[1][at], vectors.c[2][at]}, at);
      }
    }
  }
}

// det(x_u, x_v, x_w) of the frame, with the widths of the box as units of the parameters.
double RestDeterminant(const LatticeStructure& s, const std::array<int, 3>& span) {
  double determinant = Dot(s.frame.edges[0], Cross(s.frame.edges[1], s.frame.edges[2]));
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& t = s.knots[static_cast<size_t>(axis)];
    const auto k = static_cast<size_t>(span[static_cast<size_t>(axis)]);
    determinant *= (t[k + 1] - t[k]) / (s.domain_end(axis) - s.domain_begin(axis));
  }
  return determinant;
}

}  // namespace

double MakeBoxDeterminant(const LatticeStructure& s, std::span<const Vec3d> control_points,
                          const BoxPart& part, BernsteinVolume& determinant) {
  for (size_t a = 0; a < 3; ++a) determinant.count[a] = 3 * static_cast<size_t>(s.degree[a]);
  const size_t row = determinant.count[0], layer = row * determinant.count[1];
  const BoxSlopes slopes(s, control_points, part);
  std::array<SpreadVectors, 3> gradient;
  BezierBox along;
  double most = 1;
  for (size_t a = 0; a < 3; ++a) {
    most *= slopes.Along(a, along);
    SpreadInto(along, row, layer, gradient[a]);
  }

  SpreadVectors cross;  // R_v x R_w
  for (size_t a = 0; a < 3; ++a) cross.count[a] = gradient[1].count[a] + gradient[2].count[a] - 1;
  for (auto& component : cross.c) std::fill_n(component.begin(), determinant.size(), 0.0);
  const size_t run = gradient[2].LayerRun(row);
  ForEachVector(gradient[1], row, layer, [&](Vec3d a, size_t at) {
    for (size_t k = 0; k < gradient[2].count[2]; ++k) {
      AddCross(a, gradient[2], k * layer, cross, at + k * layer, run);
    }
  });
  double* const c = determinant.coefficients.data();
  std::fill_n(c, determinant.size(), 0.0);
  ForEachVector(gradient[0], row, layer, [&](Vec3d a, size_t at) {
    for (size_t k = 0; k < cross.count[2]; ++k) {
      AddDot(a, cross, k * layer, c + at + k * layer, cross.LayerRun(row));
    }
  });

  const double rest = RestDeterminant(s, part.span);
  const std::array<size_t, 3>& n = determinant.count;
  for (size_t k = 0; k < n[2]; ++k) {
    for (size_t j = 0; j < n[1]; ++j) {
      const double weight = kProductBinomials[n[2] - 1][k] * kProductBinomials[n[1] - 1][j] * rest;
      for (size_t i = 0; i < n[0]; ++i)
        c[i + row * j + layer * k] /= weight * kProductBinomials[n[0] - 1][i];
    }
  }
  return kDeterminantSlack * most / std::abs(rest);
}

}  // namespace latticed
