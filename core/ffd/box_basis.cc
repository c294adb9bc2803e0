// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/box_basis.h"

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
      if (s.knots[axis][k + 1] > s.knots[axis][k]) basis_[i][k] = MakeMatrix(axes_[i], span);
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

// Cox and de Boor's recurrence on polynomials in l.
BoxBasis::Matrix BoxBasis::MakeMatrix(int axis, int span) const {
  const auto i = static_cast<size_t>(axis);
  const std::vector<double>& t = plan_->structure.knots[i];
  const int degree = plan_->structure.degree[i];
  const auto knot = [&](int k) { return t[static_cast<size_t>(k)]; };
  const double width = knot(span + 1) - knot(span), centre = 0.5 * (knot(span) + knot(span + 1));
  Matrix n{};
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
