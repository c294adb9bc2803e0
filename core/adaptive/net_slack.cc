// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/net_slack.h"

#include <algorithm>
#include <cmath>

#include "core/ffd/box/bernstein.h"
#include "core/ffd/stage_matrices.h"

namespace latticed {
namespace {

constexpr double kHalfUlp = 0x1p-53;

double LargestRowSum(int degree) {
  const std::vector<double> inverse = InverseBernsteinMatrix(degree);
  const auto m = static_cast<size_t>(BernsteinCount(degree));
  double largest = 0;
  for (size_t row = 0; row < m; ++row) {
    double sum = 0;
    for (size_t column = 0; column < m; ++column) sum += std::abs(inverse[column * m + row]);
    largest = std::max(largest, sum);
  }
  return largest;
}

// The largest ratio of a knot to the length of a span between knots of the domain.
double KnotRatio(const LatticeStructure& structure) {
  double largest = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& knots = structure.knots[axis];
    double shortest = std::abs(knots.back() - knots.front());
    for (size_t k = 1; k < knots.size(); ++k) {
      if (knots[k] > knots[k - 1]) shortest = std::min(shortest, knots[k] - knots[k - 1]);
    }
    const double farthest = std::max(std::abs(knots.front()), std::abs(knots.back()));
    largest = std::max(largest, farthest / shortest);
  }
  return largest;
}

}  // namespace

NetSlack::NetSlack(const DeformPlan& plan)
    : plan_(plan), mesh_reach_(Norm(plan.mesh_bounds.max - plan.local_origin)) {
  const int n = plan.surface_degree();
  const double of_net = kHalfUlp * 4 * n * (n - 1) * LargestRowSum(n);
  const auto add = [&](const LatticeStructure& structure) {
    factors_.push_back(of_net * (300 + 24 * KnotRatio(structure)));
  };
  add(plan.structure);
  for (const TurnedLattice& lattice : plan.turned) add(lattice.structure);
}

std::vector<double> NetSlack::Norms(std::span<const Vec3d> control_points) const {
  std::vector<double> norms;
  norms.reserve(control_points.size());
  for (const Vec3d p : control_points) norms.push_back(Norm(p - plan_.local_origin));
  return norms;
}

double NetSlack::Of(size_t patch, std::span<const double> norms) const {
  const uint32_t box = plan_.patches[patch].box;
  const KnotSpans own = box == plan_.outside_box() ? kNoSpans : plan_.boxes[box].span;
  double slack = factors_[0] * Largest(plan_.structure, own, norms);
  for (size_t g = 0; g < plan_.turned.size(); ++g) {
    const TurnedLattice& lattice = plan_.turned[g];
    slack += factors_[1 + g] *
             Largest(lattice.structure, lattice.spans[patch], norms.subspan(lattice.first_point));
  }
  return slack;
}

double NetSlack::Largest(const LatticeStructure& s, const KnotSpans& spans,
                         std::span<const double> norms) const {
  double largest = mesh_reach_;
  if (spans == kNoSpans) return largest;
  for (int k = spans[2] - s.degree[2]; k <= spans[2]; ++k) {
    for (int j = spans[1] - s.degree[1]; j <= spans[1]; ++j) {
      for (int i = spans[0] - s.degree[0]; i <= spans[0]; ++i) {
        largest = std::max(largest, norms[static_cast<size_t>(s.Index(i, j, k))]);
      }
    }
  }
  return largest;
}

}  // namespace latticed
