// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/weighted_determinant.h"

#include <algorithm>
#include <cmath>

#include "core/folds/box_slopes.h"
#include "core/folds/triangle_forms.h"

namespace latticed {
namespace {

constexpr double kWeightedSlack = 6 * 2500 * 0x1p-53;
// Of the length of a coefficient of G or G_a: 80 u per component.
constexpr double kBoxRounding = 140 * 0x1p-53;

// |a| . |b| with moduli instead of numbers.
double SumOfModuli(Vec3d a, Vec3d b) {
  return std::abs(a.x * b.x) + std::abs(a.y * b.y) + std::abs(a.z * b.z);
}

void Subtract(Vec3d v, BezierBox& box) {
  for (int k = 0; k <= box.degree[2]; ++k) {
    for (int j = 0; j <= box.degree[1]; ++j) {
      for (int i = 0; i <= box.degree[0]; ++i) box.points[k][j][i] -= v;
    }
  }
}

}  // namespace

WeightedBox::WeightedBox(const DeformPlan& plan, uint32_t box,
                         std::span<const Vec3d> control_points, std::span<const Vec3d> offsets)
    : plan_(plan), knots_(plan.boxes[box]), control_points_(control_points), offsets_(offsets) {
  const LatticeStructure& s = plan.structure;
  for (size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    edges_[a] =
        ((knots_.upper[axis] - knots_.lower[axis]) / (s.domain_end(axis) - s.domain_begin(axis))) *
        s.frame.edges[a];
  }
  volume_ = Dot(edges_[0], Cross(edges_[1], edges_[2]));
  const BezierBox offset = ControlBox(s, offsets, knots_.span);
  most_offset_ = LargestPoint(offset, LargestComponent);
  by_control_points_.offset = LargestPoint(offset, Norm);
  const BezierBox points = ControlBox(s, control_points, knots_.span);
  for (size_t a = 0; a < 3; ++a) {
    BezierBox slopes = points;
    most_slope_[a] = Differentiate(s, knots_.span, a, slopes);
    Subtract(edges_[a], slopes);
    by_control_points_.rise += RiseOf(slopes, a);
  }
}

double WeightedBox::RiseOf(const BezierBox& slopes, size_t a) const {
  const double by_world = Norm(Cross(edges_[(a + 1) % 3], edges_[(a + 2) % 3])) / std::abs(volume_);
  const double rounding = kBoxRounding * (most_slope_[a] + LargestComponent(edges_[a]));
  return by_world * (LargestPoint(slopes, Norm) + rounding);
}

const WeightedBox::Coefficients& WeightedBox::Restrict() {
  if (coefficients_.has_value()) return *coefficients_;
  Coefficients& c = coefficients_.emplace(Coefficients{});
  c.offset = RestrictVolume(plan_.structure, offsets_, knots_.span, knots_.lower, knots_.upper);
  c.bound.offset = LargestPoint(c.offset, Norm) + kBoxRounding * most_offset_;
  const BoxSlopes slopes(plan_.structure, control_points_,
                         {knots_.span, knots_.lower, knots_.upper});
  for (size_t a = 0; a < 3; ++a) {
    slopes.Along(a, c.slopes[a]);
    Subtract(edges_[a], c.slopes[a]);
    c.bound.rise += RiseOf(c.slopes[a], a);
  }
  return c;
}

bool WeightedBox::IsWithin(const Bound& bound, size_t patch) const {
  constexpr double kSurely = 0.999;  // far from what rounding can do
  return std::ranges::max(plan_.CornerWeights(patch)) * bound.rise +
             bound.offset * Norm(plan_.PatchWeightGradient(patch)) <
         kSurely;
}

bool WeightedBox::IsNearRest(size_t patch) {
  return IsWithin(by_control_points_, patch) || IsWithin(Restrict().bound, patch);
}

double WeightedBox::MakeDeterminant(size_t p, BernsteinTriangle& determinant) {
  const Coefficients& box = Restrict();
  TriangleInBox corners;
  for (size_t c = 0; c < 3; ++c) {
    const Vec3d at = plan_.vertices[plan_.patches[p].vertex[c]].parameter;
    for (size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<int>(a);
      corners[a][c] = std::clamp(
          (at[axis] - knots_.lower[axis]) / (knots_.upper[axis] - knots_.lower[axis]), 0.0, 1.0);
    }
  }
  const TriangleForm weight = LinearForm(plan_.CornerWeights(p));
  const Vec3d gradient = plan_.PatchWeightGradient(p);
  const VectorForm offset = Compose(box.offset, corners);
  const size_t n = offset[0].degree();
  std::array<VectorForm, 3> column{MakeVectorForm(n), MakeVectorForm(n), MakeVectorForm(n)};
  double most = 1;
  for (size_t a = 0; a < 3; ++a) {
    const VectorForm slope = Compose(box.slopes[a], corners);
    const double rise = Dot(gradient, edges_[a]);
    for (size_t c = 0; c < 3; ++c) {
      column[a][c].AddProduct(weight, slope[c], 1);
      for (size_t i = 0; i <= n; ++i) {
        for (size_t j = 0; i + j <= n; ++j) {
          column[a][c].at(i, j) += Multinomial(i, j, n - i - j) * edges_[a][static_cast<int>(c)] +
                                   rise * offset[c].at(i, j);
        }
      }
    }
    const Vec3d edge = edges_[a];
    most *= LargestComponent(edge) + most_slope_[a] + SumOfModuli(gradient, edge) * most_offset_;
  }
  SetDeterminant(column, volume_, determinant);
  return kWeightedSlack * most / std::abs(volume_);
}

}  // namespace latticed
