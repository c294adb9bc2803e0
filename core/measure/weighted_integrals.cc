// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/weighted_integrals.h"

#include <algorithm>

#include "core/ffd/direct_ffd.h"
#include "core/measure/triangle_rule.h"
#include "core/points/box_map.h"
#include "core/points/point_kernel.h"

namespace latticed {
namespace {

using points::BlockSlopes;
using points::BlockVec;
using points::kBlockPoints;

// A patch at rest, relative to the origin, with the derivatives of all by the barycentrics s and t.
struct IntegratedPatch {
  Vec3d corner, s, t;
  double weight = 0, weight_s = 0, weight_t = 0;
  std::array<double, 3> local_s{}, local_t{};  // of l, m, n
};

class WeightedSum {
 public:
  WeightedSum(const DeformPlan& plan, std::span<const Vec3d> control_points, bool with_moment)
      : plan_(plan),
        control_points_(control_points),
        with_moment_(with_moment),
        boxes_(plan.structure),
        // Exact to the degree 2 m - 2.
        rule_(MakeTriangleRule(with_moment ? 2 * plan.structure.patch_degree() + 2
                                           : (3 * plan.structure.patch_degree() + 4) / 2)) {
    constexpr double kThird = 1.0 / 3;
    result_.origin =
        DirectFfd(plan, control_points).EvaluatePosition(0, {kThird, kThird, kThird}).position;
    result_.volume_gradient.resize(control_points.size());
    if (with_moment) result_.moment_gradient.resize(control_points.size());
  }

  WeightedIntegrals Run() {
    for (uint32_t box = 0; box <= plan_.outside_box(); ++box) {
      if (plan_.box_patches[box] != plan_.box_patches[box + 1]) AddBox(box);
    }
    return std::move(result_);
  }

 private:
  bool Rests(size_t patch) const {
    const std::array<double, 3> weights = plan_.CornerWeights(patch);
    return plan_.patches[patch].box == plan_.outside_box() ||
           std::ranges::all_of(weights, [](double w) { return w == 0; });
  }
  Vec3d CornerOf(size_t patch, size_t c) const {
    return plan_.vertices[plan_.patches[patch].vertex[c]].world - result_.origin;
  }

  void AddBox(uint32_t box) {
    const bool outside = box == plan_.outside_box();
    const size_t number = outside ? 0 : boxes_.BoxOf(plan_.boxes[box].span);
    map_ = boxes_.MapOf(number);
    map_.frame_origin -= result_.origin;
    BoxPolynomial polynomial;
    if (!outside) {
      polynomial = boxes_.PolynomialOf(number, control_points_);
      polynomial.origin -= result_.origin;
    }
    sums_ = {};
    for (size_t p = plan_.box_patches[box]; p < plan_.box_patches[box + 1]; ++p) {
      Rests(p) ? AddResting(p) : AddPatch(p, polynomial);
    }
    if (outside) return;
    boxes_.AddGradient(number, sums_[0], result_.volume_gradient);
    if (!with_moment_) return;
    std::vector<Vec3d> gradient(control_points_.size());
    for (size_t j = 0; j < 3; ++j) {
      std::ranges::fill(gradient, Vec3d());
      boxes_.AddGradient(number, sums_[j + 1], gradient);
      for (size_t i = 0; i < gradient.size(); ++i) result_.moment_gradient[i][j] += gradient[i];
    }
  }

  // P . n is constant on a flat triangle.
  void AddResting(size_t patch) {
    const Vec3d a = CornerOf(patch, 0), b = CornerOf(patch, 1), c = CornerOf(patch, 2);
    const double across = 0.5 * Dot(a, Cross(b - a, c - a));
    result_.volume += across / 3;
    result_.moment += 0.25 * across / 3 * (a + b + c);
  }

  void AddPatch(size_t p, const BoxPolynomial& polynomial) {
    IntegratedPatch patch;
    const std::array<double, 3> weights = plan_.CornerWeights(p);
    patch.corner = CornerOf(p, 0);
    patch.s = CornerOf(p, 1) - patch.corner;
    patch.t = CornerOf(p, 2) - patch.corner;
    patch.weight = weights[0];
    patch.weight_s = weights[1] - weights[0];
    patch.weight_t = weights[2] - weights[0];
    for (size_t a = 0; a < 3; ++a) {
      patch.local_s[a] = Dot(map_.scale[a], patch.s);
      patch.local_t[a] = Dot(map_.scale[a], patch.t);
    }
    for (size_t first = 0; first < rule_.size(); first += kBlockPoints) {
      AddPoints(patch, polynomial,
                std::span(rule_).subspan(first, std::min(kBlockPoints, rule_.size() - first)));
    }
  }

  void AddPoints(const IntegratedPatch& patch, const BoxPolynomial& polynomial,
                 std::span<const TriangleRulePoint> rule) {
    for (size_t i = 0; i < rule.size(); ++i) {
      const auto& b = rule[i].barycentrics;
      const Vec3d x = patch.corner + b[1] * patch.s + b[2] * patch.t;
      for (size_t c = 0; c < 3; ++c) rest_[c][i] = x[static_cast<int>(c)];
    }
    points::MapBlock(map_, {rest_[0].data(), rest_[1].data(), rest_[2].data()}, rule.size(),
                     local_);
    const auto& degree = plan_.structure.degree;
    points::EvaluateBlock(degree, polynomial, local_, rule.size(), values_, &slopes_);
    for (size_t i = 0; i < rule.size(); ++i) AddPoint(patch, rule[i], i);
    for (size_t f = 0; f < (with_moment_ ? 4 : 1); ++f) {
      for (auto& component : forces_[f]) {
        std::fill(component.begin() + static_cast<std::ptrdiff_t>(rule.size()), component.end(), 0);
      }
      points::SumBlock(degree, local_, forces_[f], rule.size(), sums_[f]);
    }
  }

  static Vec3d At(const BlockVec& block, size_t i) {
    return {block[0][i], block[1][i], block[2][i]};
  }
  static void Set(BlockVec& block, size_t i, Vec3d v) {
    for (size_t c = 0; c < 3; ++c) block[c][i] = v[static_cast<int>(c)];
  }

  void AddPoint(const IntegratedPatch& patch, const TriangleRulePoint& point, size_t i) {
    const auto& b = point.barycentrics;
    const double w = patch.weight + b[1] * patch.weight_s + b[2] * patch.weight_t;
    const Vec3d x = At(rest_, i), offset = At(values_, i) - x;
    Vec3d s = (1 - w) * patch.s + patch.weight_s * offset;
    Vec3d t = (1 - w) * patch.t + patch.weight_t * offset;
    for (size_t a = 0; a < 3; ++a) {
      const Vec3d slope = At(slopes_[a], i);
      s += w * patch.local_s[a] * slope;
      t += w * patch.local_t[a] * slope;
    }
    const Vec3d position = x + w * offset, directed = 0.5 * point.weight * Cross(s, t);
    const double across = Dot(position, directed);
    result_.volume += across / 3;
    Set(forces_[0], i, w * directed);
    if (!with_moment_) return;
    result_.moment += 0.25 * across * position;
    for (size_t j = 0; j < 3; ++j) {
      Set(forces_[j + 1], i, w * position[static_cast<int>(j)] * directed);
    }
  }

  const DeformPlan& plan_;
  const std::span<const Vec3d> control_points_;
  const bool with_moment_;
  const BoxMaps boxes_;
  const std::vector<TriangleRulePoint> rule_;
  WeightedIntegrals result_;
  LocalMap map_{};                  // of the present box
  std::array<BoxNumbers, 4> sums_;  // of l^p m^q n^r w n dA there, then of that times P_j
  BlockVec rest_, local_, values_;  // of the present points
  BlockSlopes slopes_;
  std::array<BlockVec, 4> forces_;
};

}  // namespace

WeightedIntegrals IntegrateWeighted(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                    bool with_moment) {
  return WeightedSum(plan, control_points, with_moment).Run();
}

}  // namespace latticed
