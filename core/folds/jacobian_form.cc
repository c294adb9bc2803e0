// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/jacobian_form.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/folds/box_slopes.h"
#include "core/folds/frame_gradients.h"

namespace latticed {
namespace {

constexpr double kProductRounding = 0x1p-48;
constexpr double kSumRounding = 0x1p-40;

// How much a linear change of J, whose square is lost, counts beside what is lost at once.
constexpr double kLinearLoss = 0.3;

using Columns = std::array<Vec3d, 3>;

struct LinearLeast {
  double value = 0;
  Vec3d place;
};

// The least linear . t in the cube.
LinearLeast LeastInCube(Vec3d linear) {
  LinearLeast least;
  for (int k = 0; k < 3; ++k) {
    least.place[k] = linear[k] > 0 ? -1 : 1;
    least.value -= std::abs(linear[k]);
  }
  return least;
}

// The same in its part inside the plane: from the best corner of the cube, it goes the cheapest way to the plane.
LinearLeast LeastInside(Vec3d linear, const CellPlane& plane) {
  LinearLeast least = LeastInCube(linear);
  double excess = Dot(plane.normal, least.place) - plane.bound;
  std::array<int, 3> axes{0, 1, 2};
  std::ranges::sort(axes, {}, [&](int k) {
    const double price = std::abs(linear[k] / plane.normal[k]);
    return std::isnan(price) ? 0 : price;
  });
  for (const int k : axes) {
    if (!(excess > 0)) return least;
    const double gain = 2 * plane.normal[k] * least.place[k];
    if (!(gain > 0)) continue;
    const double share = std::min(1.0, excess / gain);
    least.value += 2 * share * std::abs(linear[k]);
    least.place[k] *= 1 - 2 * share;
    excess -= share * gain;
    if (share < 1) return least;
  }
  if (excess > 0) least.value = std::numeric_limits<double>::infinity();  // the part is empty
  return least;
}

// sum over l of the component l of the cross product of columns l + 1 and l + 2: the principal minors if a = b.
double Minors(const Columns& a, const Columns& b) {
  double sum = 0;
  for (size_t l = 0; l < 3; ++l) {
    sum += Cross(a[(l + 1) % 3], b[(l + 2) % 3])[static_cast<int>(l)];
  }
  return sum;
}

// How much the minors and the determinant of sum_k t_k E_k, which are polynomials in t, take from the bound, by their
// coefficients. `negative`: their factor, det M, is below 0. The squares t_k^2 are not.
double HigherTerms(const std::array<Columns, 3>& e, bool negative) {
  double most = 0;
  for (size_t k = 0; k < 3; ++k) {
    const double minors = Minors(e[k], e[k]);
    most += std::max(0.0, negative ? minors : -minors);
    for (size_t m = 0; m < k; ++m) most += std::abs(Minors(e[k], e[m]) + Minors(e[m], e[k]));
  }
  // By how often t_0 and t_1 occur.
  std::array<std::array<double, 4>, 4> cubic{};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      const Vec3d cross = Cross(e[i][0], e[j][1]);
      for (size_t k = 0; k < 3; ++k) {
        const auto count = [&](size_t of) {
          return size_t{i == of} + size_t{j == of} + size_t{k == of};
        };
        cubic[count(0)][count(1)] += Dot(cross, e[k][2]);
      }
    }
  }
  for (const auto& row : cubic) {
    for (const double c : row) most += std::abs(c);
  }
  return most;
}

// The same with moduli of the columns alone.
double HigherTermsOfModuli(const Columns& reach) {
  double most = Dot(reach[0], CrossOfModuli(reach[1], reach[2]));
  for (size_t l = 0; l < 3; ++l) {
    most += CrossOfModuli(reach[(l + 1) % 3], reach[(l + 2) % 3])[static_cast<int>(l)];
  }
  return most;
}

}  // namespace

JacobianForm& JacobianForm::operator+=(const JacobianForm& other) {
  for (size_t l = 0; l < 3; ++l) {
    centre[l] += other.centre[l];
    for (size_t k = 0; k < 3; ++k) {
      slope[l][k] += other.slope[l][k];
      bend[l][k] += other.bend[l][k];
    }
  }
  return *this;
}

DeterminantBound BoundDeterminant(const JacobianForm& form, double rest,
                                  std::span<const CellPlane> planes) {
  const auto& m = form.centre;
  const std::array<Vec3d, 3> cofactor{Cross(m[1], m[2]), Cross(m[2], m[0]), Cross(m[0], m[1])};
  const double determinant = Dot(m[0], cofactor[0]);
  const double ratio = determinant / rest;
  Vec3d linear;
  for (size_t l = 0; l < 3; ++l) {
    for (int k = 0; k < 3; ++k) {
      linear[k] += Dot(cofactor[l], form.slope[l][static_cast<size_t>(k)]) / rest;
    }
  }
  LinearLeast least = LeastInCube(linear);
  const double moduli = -least.value;
  for (const CellPlane& plane : planes) {
    const LinearLeast inside = LeastInside(linear, plane);
    if (inside.value > least.value) least = inside;
  }

  Columns inverse, inverse_moduli;  // rows of N
  for (size_t i = 0; i < 3; ++i) {
    inverse[i] = cofactor[i] / determinant;
    inverse_moduli[i] = Moduli(inverse[i]);
  }
  const auto times = [](const Columns& rows, Vec3d v) {
    return Vec3d{Dot(rows[0], v), Dot(rows[1], v), Dot(rows[2], v)};
  };
  DeterminantBound bound{.place = least.place};
  std::array<Columns, 3> slopes;  // N L_k
  Columns linear_reach, reach;    // of the columns of E: of its linear part, and of all of it
  double lost = 0, most_residual = 0;
  for (size_t l = 0; l < 3; ++l) {
    Vec3d size = Moduli(m[l]), radius;
    for (size_t k = 0; k < 3; ++k) {
      size += Moduli(form.slope[l][k]);
      slopes[k][l] = times(inverse, form.slope[l][k]);
      const Vec3d slope = Moduli(slopes[k][l]);
      const Vec3d bend = times(inverse_moduli, form.bend[l][k]);
      bound.loss[static_cast<int>(k)] +=
          kLinearLoss * LargestComponent(slope) + LargestComponent(bend);
      linear_reach[l] += slope;
      radius += bend;
    }
    Vec3d residual = times(inverse, m[l]);
    residual[static_cast<int>(l)] -= 1;
    most_residual += LargestComponent(residual);
    radius += times(inverse_moduli, kProductRounding * size) + Moduli(residual);
    reach[l] = linear_reach[l] + radius;
    lost += radius[static_cast<int>(l)];
  }
  const double higher = HigherTermsOfModuli(reach);
  lost += HigherTerms(slopes, ratio < 0) + (higher - HigherTermsOfModuli(linear_reach));
  bound.least = ratio + least.value - std::abs(ratio) * lost -
                kSumRounding * (std::abs(ratio) * (1 + lost + higher) + moduli);
  constexpr double kMostResidual = 0.125;
  if (!(most_residual < kMostResidual)) bound.least = -std::numeric_limits<double>::infinity();
  if (!std::isfinite(ratio)) bound.least = std::numeric_limits<double>::quiet_NaN();
  if (least.value == std::numeric_limits<double>::infinity()) bound.least = least.value;
  return bound;
}

}  // namespace latticed
