// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/box_polynomials.h"

#include <cmath>
#include <utility>

#include "core/adaptive/curvature_slack.h"

namespace latticed::fused {
namespace {

Vec3d Permute(Vec3d v, const std::array<int, 3>& axes) {
  return {v[axes[0]], v[axes[1]], v[axes[2]]};
}

// An upper bound of the Frobenius norm of J in the box: the sum, over all coefficients, of |coefficient| times |gradient of
// its power product|.
double SlopeBound(const std::array<Vec3d, 64>& c, const std::array<int, 3>& degree,
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
  return slope;
}

// An upper bound of the polynomial's length in the box.
double OffsetBound(const std::array<Vec3d, 64>& c, const std::array<int, 3>& degree) {
  double length = 0;
  for (int a = 0; a <= degree[0]; ++a) {
    for (int b = 0; b <= degree[1]; ++b) {
      for (int d = 0; d <= degree[2]; ++d) {
        const Vec3d& v = c[static_cast<size_t>((a * (degree[1] + 1) + b) * (degree[2] + 1) + d)];
        length += std::exp2(-(a + b + d)) * Norm(v);
      }
    }
  }
  return length;
}

}  // namespace

BoxPolynomials::BoxPolynomials(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)), map_(plan_->structure), basis_(plan_) {}

BoxPolynomial BoxPolynomials::Make(uint32_t box, std::span<const Vec3d> control_points) const {
  const std::array<Vec3d, BoxBasis::kMostTerms> c = Coefficients(box, control_points);
  BoxPolynomial polynomial{};
  for (size_t i = 0; i < c.size(); ++i) {
    const Vec3f f = ToFloat(c[i]);
    polynomial.coefficient[i] = {f.x, f.y, f.z};
  }
  const double slope = SlopeBound(c, basis_.degree(), basis_.Gradients(box));
  // The spectral norm of cof J is at most half the squared Frobenius norm of J.
  polynomial.cofactor_bound = static_cast<float>(0.5 * slope * slope);
  if (plan_->is_weighted()) {
    polynomial.slope_bound = static_cast<float>(slope);
    polynomial.offset_bound = static_cast<float>(OffsetBound(c, basis_.degree()));
    polynomial.rest = Rest(box);
  }
  return polynomial;
}

std::array<std::array<float, 3>, 4> BoxPolynomials::Rest(uint32_t box) const {
  const Vec3d centre = basis_.Centre(box);
  const Vec3d world = box == plan_->outside_box() ? centre : map_.ToWorld(centre);
  const std::array<Vec3d, 3> by_local = WorldByLocal(box);
  std::array<std::array<float, 3>, 4> rest;
  for (size_t i = 0; i < 4; ++i) {
    const Vec3f f = ToFloat(i == 0 ? world - plan_->local_origin : by_local[i - 1]);
    rest[i] = {f.x, f.y, f.z};
  }
  return rest;
}

std::array<Vec3d, BoxBasis::kMostTerms> BoxPolynomials::Coefficients(
    uint32_t box, std::span<const Vec3d> control_points) const {
  if (!plan_->is_weighted()) return basis_.Polynomial(box, control_points);
  return box == plan_->outside_box() ? std::array<Vec3d, BoxBasis::kMostTerms>{}
                                     : basis_.OffsetPolynomial(box, control_points);
}

std::array<float, 6> BoxPolynomials::Slack(uint32_t box, std::span<const Vec3d> control_points,
                                           Vec3d reach) const {
  const auto slack = CurvatureSlack(basis_.Polynomial(box, control_points), basis_.degree(), reach);
  std::array<float, 6> rounded;
  for (size_t k = 0; k < slack.size(); ++k) rounded[k] = static_cast<float>(slack[k]);
  return rounded;
}

Vec3d BoxPolynomials::Local(uint32_t box, const PlanVertex& vertex) const {
  return basis_.Local(box, vertex);
}

Vec3d BoxPolynomials::LocalDirection(uint32_t box, Vec3d world) const {
  const Vec3d d = box == plan_->outside_box() ? world : map_.DirectionToParameter(world);
  const Vec3d width = basis_.Width(box);
  return Permute({d.x / width.x, d.y / width.y, d.z / width.z}, basis_.axes());
}

std::array<Vec3d, 3> BoxPolynomials::WorldByLocal(uint32_t box) const {
  const std::array<Vec3d, 3> row = basis_.Gradients(box);
  const double determinant = Dot(row[0], Cross(row[1], row[2]));
  return {Cross(row[1], row[2]) / determinant, Cross(row[2], row[0]) / determinant,
          Cross(row[0], row[1]) / determinant};
}

Vec3d BoxPolynomials::LocalConormal(uint32_t box, Vec3d world_normal) const {
  const std::array<Vec3d, 3> row = basis_.Gradients(box);
  return {Dot(Cross(row[1], row[2]), world_normal), Dot(Cross(row[2], row[0]), world_normal),
          Dot(Cross(row[0], row[1]), world_normal)};
}

}  // namespace latticed::fused
