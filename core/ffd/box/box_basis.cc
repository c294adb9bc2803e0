// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box/box_basis.h"

#include <algorithm>
#include <utility>

namespace latticed {

BoxBasis::BoxBasis(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)), axes_{0, 1, 2} {
  const LatticeStructure& s = plan_->structure;
  std::stable_sort(axes_.begin(), axes_.end(), [&](int a, int b) {
    return s.degree[static_cast<size_t>(a)] > s.degree[static_cast<size_t>(b)];
  });
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<size_t>(axes_[i]);
    basis_[i].resize(static_cast<size_t>(s.size[axis]));
    for (int span = s.degree[axis]; span < s.size[axis]; ++span) {
      const auto k = static_cast<size_t>(span);
      if (s.knots[axis][k + 1] > s.knots[axis][k]) {
        basis_[i][k] = MakeSpanBasis(s.knots[axis], s.degree[axis], span);
      }
    }
  }
  const FrameMap map(s);
  const Vec3d ex = map.DirectionToParameter({1, 0, 0}), ey = map.DirectionToParameter({0, 1, 0}),
              ez = map.DirectionToParameter({0, 0, 1});
  for (int a = 0; a < 3; ++a) parameter_gradient_[static_cast<size_t>(a)] = {ex[a], ey[a], ez[a]};
}

std::array<int, 3> BoxBasis::degree() const {
  std::array<int, 3> degree;
  for (size_t i = 0; i < 3; ++i) {
    degree[i] = plan_->structure.degree[static_cast<size_t>(axes_[i])];
  }
  return degree;
}

template <typename Point>
std::array<Vec3d, BoxBasis::kMostTerms> BoxBasis::Contract(uint32_t box, const Point& point) const {
  const std::array<int, 3> degree = this->degree(), &axes = axes_;
  std::array<Vec3d, kMostTerms> c{};
  const auto at = [&](int i, int j, int k) -> Vec3d& {
    return c[static_cast<size_t>((i * (degree[1] + 1) + j) * (degree[2] + 1) + k)];
  };
  const std::array<int, 3>& span = plan_->boxes[box].span;
  std::array<const BoxBasis::Matrix*, 3> basis;
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<size_t>(axes[i]);
    basis[i] = &basis_[i][static_cast<size_t>(span[axis])];
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
        const Vec3d p =
            point(static_cast<size_t>(plan_->structure.Index(index[0], index[1], index[2])));
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
  return c;
}

std::array<Vec3d, BoxBasis::kMostTerms> BoxBasis::Polynomial(
    uint32_t box, std::span<const Vec3d> control_points) const {
  if (box != plan_->outside_box()) {
    return Contract(box, [&](size_t i) { return control_points[i] - plan_->local_origin; });
  }
  const std::array<int, 3> degree = this->degree(), &axes = axes_;
  std::array<Vec3d, kMostTerms> c{};
  const auto at = [&](int i, int j, int k) -> Vec3d& {
    return c[static_cast<size_t>((i * (degree[1] + 1) + j) * (degree[2] + 1) + k)];
  };
  const Vec3d width = Width(box);
  at(0, 0, 0) = Centre(box) - plan_->local_origin;
  at(1, 0, 0)[axes[0]] = width[axes[0]];
  at(0, 1, 0)[axes[1]] = width[axes[1]];
  at(0, 0, 1)[axes[2]] = width[axes[2]];
  return c;
}

std::array<Vec3d, BoxBasis::kMostTerms> BoxBasis::OffsetPolynomial(
    uint32_t box, std::span<const Vec3d> control_points) const {
  return Contract(box, [&](size_t i) { return control_points[i] - plan_->identity_points[i]; });
}

Vec3d BoxBasis::Local(uint32_t box, const PlanVertex& vertex) const {
  const Vec3d point = box == plan_->outside_box() ? vertex.world : vertex.parameter;
  const Vec3d centre = Centre(box), width = Width(box);
  Vec3d local;
  for (int i = 0; i < 3; ++i) {
    const int a = axes_[static_cast<size_t>(i)];
    local[i] = (point[a] - centre[a]) / width[a];
  }
  return local;
}

Vec3d BoxBasis::Centre(uint32_t box) const {
  const KnotBox& b = plan_->boxes[box];
  return 0.5 * (b.lower + b.upper);
}

Vec3d BoxBasis::Width(uint32_t box) const {
  const KnotBox& b = plan_->boxes[box];
  Vec3d width = b.upper - b.lower;
  for (int a = 0; a < 3; ++a) {
    if (!(width[a] > 0)) width[a] = 1;  // flat outside pieces
  }
  return width;
}

std::array<Vec3d, 3> BoxBasis::Gradients(uint32_t box) const {
  const Vec3d width = Width(box);
  std::array<Vec3d, 3> gradients;
  for (size_t i = 0; i < 3; ++i) {
    const int axis = axes_[i];
    if (box == plan_->outside_box()) {
      gradients[i][axis] = 1 / width[axis];
    } else {
      gradients[i] = parameter_gradient_[static_cast<size_t>(axis)] / width[axis];
    }
  }
  return gradients;
}

}  // namespace latticed
