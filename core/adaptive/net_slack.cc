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

double FactorOfNet(int n) { return kHalfUlp * 4 * n * (n - 1) * LargestRowSum(n); }

}  // namespace

NetSlack::NetSlack(const DeformPlan& plan)
    : plan_(plan),
      mesh_reach_(Norm(plan.mesh_bounds.max - plan.local_origin)),
      of_net_(FactorOfNet(plan.surface_degree())) {}

std::vector<double> NetSlack::Norms(std::span<const Vec3d> control_points) const {
  std::vector<double> norms;
  norms.reserve(control_points.size());
  for (const Vec3d p : control_points) norms.push_back(Norm(p - plan_.local_origin));
  return norms;
}

double NetSlack::Of(size_t patch, std::span<const double> norms) const {
  double slack = SlackAtRest(mesh_reach_);
  const uint32_t box = plan_.patches[patch].box;
  if (box != plan_.outside_box()) {
    slack += OfLattice(plan_.structure, plan_.boxes[box].span, norms);
  }
  for (const TurnedLattice& lattice : plan_.turned) {
    if (lattice.spans[patch] == kNoSpans) continue;
    slack += OfLattice(lattice.structure, lattice.spans[patch], norms.subspan(lattice.first_point));
  }
  return of_net_ * slack;
}

double NetSlack::OfLattice(const LatticeStructure& s, const KnotSpans& spans,
                           std::span<const double> norms) const {
  double largest = mesh_reach_, ratio = 0;
  for (size_t a = 0; a < 3; ++a) ratio = std::max(ratio, KnotRatio(s.knots[a].data(), spans[a]));
  for (int k = spans[2] - s.degree[2]; k <= spans[2]; ++k) {
    for (int j = spans[1] - s.degree[1]; j <= spans[1]; ++j) {
      for (int i = spans[0] - s.degree[0]; i <= spans[0]; ++i) {
        largest = std::max(largest, norms[static_cast<size_t>(s.Index(i, j, k))]);
      }
    }
  }
  return SlackOfLattice(ratio, largest);
}

}  // namespace latticed
