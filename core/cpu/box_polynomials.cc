// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/box_polynomials.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace latticed::fused {
namespace {

Vec3d Permute(Vec3d v, const std::array<int, 3>& axes) {
  return {v[axes[0]], v[axes[1]], v[axes[2]]};
}

// A bound of ||cof J|| over the box: half the squared Frobenius norm of a bound of J.
double CofactorBound(const std::array<Vec3d, 64>& c, const std::array<int, 3>& degree,
                     const std::array<Vec3d, 3>& gradient) {
  std::array<Vec3d, 3> slope{};  // bound of |dR / dl_axis|, by component
  for (int a = 0; a <= degree[0]; ++a) {
    for (int b = 0; b <= degree[1]; ++b) {
      for (int d = 0; d <= degree[2]; ++d) {
        const Vec3d v = c[static_cast<size_t>((a * (degree[1] + 1) + b) * (degree[2] + 1) + d)];
        const Vec3d size{std::abs(v.x), std::abs(v.y), std::abs(v.z)};
        const double power = std::exp2(1 - (a + b + d));  // |l| <= 1/2
        slope[0] += (a * power) * size;
        slope[1] += (b * power) * size;
        slope[2] += (d * power) * size;
      }
    }
  }
  double norm = 0;
  for (size_t i = 0; i < 3; ++i) norm += Norm(slope[i]) * Norm(gradient[i]);
  return 0.5 * norm * norm;
}

}  // namespace

BoxPolynomials::BoxPolynomials(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)), map_(plan_->structure), axes_{0, 1, 2} {
  const LatticeStructure& s = plan_->structure;
  std::stable_sort(axes_.begin(), axes_.end(), [&](int a, int b) {
    return s.degree[static_cast<size_t>(a)] > s.degree[static_cast<size_t>(b)];
  });
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<size_t>(axis);
    basis_[i].resize(static_cast<size_t>(s.size[i]));
    for (int span = s.degree[i]; span < s.size[i]; ++span) {
      const auto k = static_cast<size_t>(span);
      if (s.knots[i][k + 1] > s.knots[i][k]) basis_[i][k] = MakeBasis(axis, span);
    }
  }
  const Vec3d ex = map_.DirectionToParameter({1, 0, 0}), ey = map_.DirectionToParameter({0, 1, 0}),
              ez = map_.DirectionToParameter({0, 0, 1});
  for (int a = 0; a < 3; ++a) world_gradient_[static_cast<size_t>(a)] = {ex[a], ey[a], ez[a]};
}

std::array<int, 3> BoxPolynomials::degree() const {
  std::array<int, 3> degree;
  for (size_t i = 0; i < 3; ++i) {
    degree[i] = plan_->structure.degree[static_cast<size_t>(axes_[i])];
  }
  return degree;
}

// Cox and de Boor's recurrence on polynomials in l.
BoxPolynomials::BasisMatrix BoxPolynomials::MakeBasis(int axis, int span) const {
  const auto i = static_cast<size_t>(axis);
  const std::vector<double>& t = plan_->structure.knots[i];
  const int degree = plan_->structure.degree[i];
  const auto knot = [&](int k) { return t[static_cast<size_t>(k)]; };
  const double width = knot(span + 1) - knot(span), centre = 0.5 * (knot(span) + knot(span + 1));
  BasisMatrix n{};
  n[0][0] = 1;
  for (int j = 1; j <= degree; ++j) {
    std::array<double, 4> saved{};
    for (int r = 0; r < j; ++r) {
      const double low = knot(span + 1 - j + r), high = knot(span + r + 1);
      const auto row = static_cast<size_t>(r);
      const std::array<double, 4> old = n[row];
      std::array<double, 4> next{};
      for (size_t k = 0; k < 4; ++k) {
        const double term = old[k] / (high - low);
        n[row][k] =
            saved[k] + (high - centre) * term - (k > 0 ? width * old[k - 1] / (high - low) : 0);
        next[k] = (centre - low) * term + (k > 0 ? width * old[k - 1] / (high - low) : 0);
      }
      saved = next;
    }
    n[static_cast<size_t>(j)] = saved;
  }
  return n;
}

Vec3d BoxPolynomials::Width(uint32_t box) const {
  const KnotBox& b = plan_->boxes[box];
  Vec3d width = b.upper - b.lower;
  for (int a = 0; a < 3; ++a) {
    if (!(width[a] > 0)) width[a] = 1;  // flat outside pieces
  }
  return width;
}

BoxPolynomial BoxPolynomials::Make(uint32_t box, std::span<const Vec3d> control_points) const {
  const std::array<int, 3> degree = this->degree();
  std::array<Vec3d, 64> c{};
  std::array<Vec3d, 3> gradient;
  const auto at = [&](int i, int j, int k) -> Vec3d& {
    return c[static_cast<size_t>((i * (degree[1] + 1) + j) * (degree[2] + 1) + k)];
  };
  const Vec3d width = Width(box);
  if (box == plan_->outside_box()) {
    const KnotBox& b = plan_->boxes[box];
    at(0, 0, 0) = 0.5 * (b.lower + b.upper) - plan_->local_origin;
    at(1, 0, 0)[axes_[0]] = width[axes_[0]];
    at(0, 1, 0)[axes_[1]] = width[axes_[1]];
    at(0, 0, 1)[axes_[2]] = width[axes_[2]];
    for (size_t i = 0; i < 3; ++i) gradient[i][axes_[i]] = 1 / width[axes_[i]];
  } else {
    const std::array<int, 3>& span = plan_->boxes[box].span;
    std::array<const BasisMatrix*, 3> basis;
    for (size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<size_t>(axes_[i]);
      basis[i] = &basis_[axis][static_cast<size_t>(span[axis])];
      gradient[i] = world_gradient_[axis] / width[axes_[i]];
    }
    // Contract one axis after the other; r, s, t run over basis functions, a, b, k over powers.
    std::array<int, 3> index;
    for (int r = 0; r <= degree[0]; ++r) {
      std::array<std::array<Vec3d, 4>, 4> plane{};  // [b][k]
      for (int s = 0; s <= degree[1]; ++s) {
        std::array<Vec3d, 4> line{};  // [k]
        for (int t = 0; t <= degree[2]; ++t) {
          const std::array<int, 3> local{r, s, t};
          for (size_t i = 0; i < 3; ++i) {
            const auto axis = static_cast<size_t>(axes_[i]);
            index[axis] = span[axis] - degree[i] + local[i];
          }
          const Vec3d p = control_points[static_cast<size_t>(
                              plan_->structure.Index(index[0], index[1], index[2]))] -
                          plan_->local_origin;
          for (size_t k = 0; k < 4; ++k) line[k] += (*basis[2])[static_cast<size_t>(t)][k] * p;
        }
        for (size_t b = 0; b < 4; ++b) {
          for (size_t k = 0; k < 4; ++k) {
            plane[b][k] += (*basis[1])[static_cast<size_t>(s)][b] * line[k];
          }
        }
      }
      for (int a = 0; a <= degree[0]; ++a) {
        const double weight = (*basis[0])[static_cast<size_t>(r)][static_cast<size_t>(a)];
        for (int b = 0; b <= degree[1]; ++b) {
          for (int k = 0; k <= degree[2]; ++k) {
            at(a, b, k) += weight * plane[static_cast<size_t>(b)][static_cast<size_t>(k)];
          }
        }
      }
    }
  }
  BoxPolynomial polynomial{};
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3f f = ToFloat(c[i]);
    polynomial.coefficient[i] = {f.x, f.y, f.z};
  }
  polynomial.cofactor_bound = static_cast<float>(CofactorBound(c, degree, gradient));
  return polynomial;
}

Vec3d BoxPolynomials::Local(uint32_t box, const PlanVertex& vertex) const {
  const KnotBox& b = plan_->boxes[box];
  const Vec3d point = box == plan_->outside_box() ? vertex.world : vertex.parameter;
  const Vec3d centre = 0.5 * (b.lower + b.upper), width = Width(box);
  Vec3d local;
  for (int a = 0; a < 3; ++a) local[a] = (point[a] - centre[a]) / width[a];
  return Permute(local, axes_);
}

Vec3d BoxPolynomials::LocalDirection(uint32_t box, Vec3d world) const {
  const Vec3d d = box == plan_->outside_box() ? world : map_.DirectionToParameter(world);
  const Vec3d width = Width(box);
  return Permute({d.x / width.x, d.y / width.y, d.z / width.z}, axes_);
}

}  // namespace latticed::fused
