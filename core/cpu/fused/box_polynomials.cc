// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/box_polynomials.h"

#include <cmath>
#include <utility>

namespace latticed::fused {
namespace {

Vec3d Permute(Vec3d v, const std::array<int, 3>& axes) {
  return {v[axes[0]], v[axes[1]], v[axes[2]]};
}

// An upper bound of the spectral norm of cof J in the box. It is at most half the squared Frobenius norm of J.
// That norm is at most the sum, over all coefficients, of |coefficient| times |gradient of its power product|.
double CofactorBound(const std::array<Vec3d, 64>& c, const std::array<int, 3>& degree,
                     const std::array<Vec3d, 3>& gradient) {
  const double g[3] = {Norm(gradient[0]), Norm(gradient[1]), Norm(gradient[2])};
  double slope = 0;
  for (int a = 0; a <= degree[0]; ++a) {
    for (int b = 0; b <= degree[1]; ++b) {
      for (int d = 0; d <= degree[2]; ++d) {
        const Vec3d& v = c[static_cast<size_t>((a * (degree[1] + 1) + b) * (degree[2] + 1) + d)];
        const double power = std::exp2(1 - (a + b + d));  // |l| <= 1/2
        slope += (a * g[0] + b * g[1] + d * g[2]) * power * Norm(v);
      }
    }
  }
  return 0.5 * slope * slope;
}

}  // namespace

BoxPolynomials::BoxPolynomials(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)), map_(plan_->structure), basis_(plan_) {}

BoxPolynomial BoxPolynomials::Make(uint32_t box, std::span<const Vec3d> control_points) const {
  const std::array<int, 3> degree = basis_.degree(), &axes = basis_.axes();
  std::array<Vec3d, 64> c{};
  const auto at = [&](int i, int j, int k) -> Vec3d& {
    return c[static_cast<size_t>((i * (degree[1] + 1) + j) * (degree[2] + 1) + k)];
  };
  const Vec3d width = basis_.Width(box);
  if (box == plan_->outside_box()) {
    at(0, 0, 0) = basis_.Centre(box) - plan_->local_origin;
    at(1, 0, 0)[axes[0]] = width[axes[0]];
    at(0, 1, 0)[axes[1]] = width[axes[1]];
    at(0, 0, 1)[axes[2]] = width[axes[2]];
  } else {
    const std::array<int, 3>& span = plan_->boxes[box].span;
    std::array<const BoxBasis::Matrix*, 3> basis;
    for (size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<size_t>(axes[i]);
      basis[i] = &basis_.matrices(i)[static_cast<size_t>(span[axis])];
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
            const auto axis = static_cast<size_t>(axes[i]);
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
  polynomial.cofactor_bound = static_cast<float>(CofactorBound(c, degree, basis_.Gradients(box)));
  return polynomial;
}

Vec3d BoxPolynomials::Local(uint32_t box, const PlanVertex& vertex) const {
  const Vec3d point = box == plan_->outside_box() ? vertex.world : vertex.parameter;
  const Vec3d centre = basis_.Centre(box), width = basis_.Width(box);
  Vec3d local;
  for (int a = 0; a < 3; ++a) local[a] = (point[a] - centre[a]) / width[a];
  return Permute(local, basis_.axes());
}

Vec3d BoxPolynomials::LocalDirection(uint32_t box, Vec3d world) const {
  const Vec3d d = box == plan_->outside_box() ? world : map_.DirectionToParameter(world);
  const Vec3d width = basis_.Width(box);
  return Permute({d.x / width.x, d.y / width.y, d.z / width.z}, basis_.axes());
}

Vec3d BoxPolynomials::LocalConormal(uint32_t box, Vec3d world_normal) const {
  const std::array<Vec3d, 3> row = basis_.Gradients(box);
  return {Dot(Cross(row[1], row[2]), world_normal), Dot(Cross(row[2], row[0]), world_normal),
          Dot(Cross(row[0], row[1]), world_normal)};
}

}  // namespace latticed::fused
