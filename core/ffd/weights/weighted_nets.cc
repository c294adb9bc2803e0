// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/weights/weighted_nets.h"

#include <array>

namespace latticed {
namespace {

// The place of T_{i,j,n-i-j} in a net of degree n: rows of falling i, in each of them falling j.
size_t NetPlace(size_t n, size_t i, size_t j) {
  const size_t row = n - i;
  return row * (row + 1) / 2 + row - j;
}

class PatchNet {
 public:
  PatchNet(const DeformPlan& plan, size_t patch, const double* net)
      : n_(static_cast<size_t>(plan.structure.patch_degree())),
        weight_(plan.CornerWeights(patch)),
        net_(net) {
    for (size_t c = 0; c < 3; ++c) rest_[c] = plan.vertices[plan.patches[patch].vertex[c]].world;
  }

  // Of P, where the powers sum to n + 1.
  Vec3d Point(const std::array<size_t, 3>& power) const {
    Vec3d sum;
    for (size_t c = 0; c < 3; ++c) {
      if (power[c] == 0) continue;
      std::array<size_t, 3> before = power;
      --before[c];
      sum += static_cast<double>(power[c]) * (rest_[c] + weight_[c] * Offset(before));
    }
    return sum / static_cast<double>(n_ + 1);
  }

 private:
  // Of F - x, where the powers sum to n.
  Vec3d Offset(const std::array<size_t, 3>& power) const {
    const double* at = net_ + 3 * NetPlace(n_, power[0], power[1]);
    Vec3d rest;
    for (size_t c = 0; c < 3; ++c) rest += static_cast<double>(power[c]) * rest_[c];
    return Vec3d{at[0], at[1], at[2]} - rest / static_cast<double>(n_);
  }

  const size_t n_;
  const std::array<double, 3> weight_;
  const double* const net_;
  std::array<Vec3d, 3> rest_;
};

}  // namespace

std::vector<double> WeighNets(const DeformPlan& plan, size_t first, std::span<const double> nets) {
  const auto n = static_cast<size_t>(plan.structure.patch_degree());
  const size_t doubles = 3 * (n + 1) * (n + 2) / 2, count = nets.size() / doubles;
  std::vector<double> weighted;
  weighted.reserve(count * 3 * (n + 2) * (n + 3) / 2);
  for (size_t k = 0; k < count; ++k) {
    const PatchNet net(plan, first + k, nets.data() + k * doubles);
    for (size_t i = n + 2; i-- > 0;) {
      for (size_t j = n + 2 - i; j-- > 0;) {
        const Vec3d point = net.Point({i, j, n + 1 - i - j});
        weighted.insert(weighted.end(), {point.x, point.y, point.z});
      }
    }
  }
  return weighted;
}

}  // namespace latticed
