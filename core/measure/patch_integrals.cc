// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_integrals.h"

#include <algorithm>
#include <optional>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "core/measure/triangle_rule.h"
#include "core/points/box_map.h"
#include "core/points/point_blocks.h"

namespace latticed {
namespace {

using points::At;
using points::BlockSlopes;
using points::BlockVec;
using points::kBlockPoints;
using points::Set;

// A patch at rest, relative to the origin, with the derivatives of all by the barycentrics s and t.
struct IntegratedPatch {
  Vec3d corner, s, t;
  double weight = 1, weight_s = 0, weight_t = 0;
};

// A lattice: what it moves the points of the present patch, and its sums over the patches of its present box.
class Summand {
 public:
  // The control points of the lattice are those of the plan from `first` on.
  Summand(const LatticeStructure& structure, std::span<const Vec3d> of_plan, size_t first,
          Vec3d origin)
      : boxes_(structure),
        first_(first),
        control_points_(
            of_plan.subspan(first, static_cast<size_t>(structure.control_point_count()))),
        origin_(origin) {}

  // Prepares for a patch in the box with these spans, or for one that the lattice does not reach.
  void Take(const IntegratedPatch& patch, const KnotSpans& spans, PatchIntegrals& result) {
    reaches_ = spans != kNoSpans;
    if (!reaches_) return;
    if (const size_t box = boxes_.BoxOf(spans); box_ != box) {
      AddSums(result);
      box_ = box;
      map_ = boxes_.MapOf(box);
      map_.frame_origin -= origin_;
      polynomial_ = boxes_.PolynomialOf(box, control_points_);
      polynomial_.origin -= origin_;
    }
    for (size_t a = 0; a < 3; ++a) {
      local_s_[a] = Dot(map_.scale[a], patch.s);
      local_t_[a] = Dot(map_.scale[a], patch.t);
    }
  }
  bool reaches() const { return reaches_; }

  // Adds F - x at points, and its derivatives by s and t.
  void AddMoves(const IntegratedPatch& patch, const BlockVec& rest, size_t count,
                std::array<BlockVec, 3>& moves) {
    points::MapBlock(map_, {rest[0].data(), rest[1].data(), rest[2].data()}, count, local_);
    points::EvaluateBlock(boxes_.structure().degree, polynomial_, local_, count, values_, &slopes_);
    for (size_t i = 0; i < count; ++i) {
      Vec3d s = -patch.s, t = -patch.t;
      for (size_t a = 0; a < 3; ++a) {
        s += local_s_[a] * At(slopes_[a], i);
        t += local_t_[a] * At(slopes_[a], i);
      }
      Set(moves[0], i, At(moves[0], i) + At(values_, i) - At(rest, i));
      Set(moves[1], i, At(moves[1], i) + s);
      Set(moves[2], i, At(moves[2], i) + t);
    }
  }
  void AddForces(std::span<const BlockVec> forces, size_t count) {
    for (size_t f = 0; f < forces.size(); ++f) {
      points::SumBlock(boxes_.structure().degree, local_, forces[f], count, sums_[f]);
    }
  }
  // Adds what the sums of the present box are for control points, and begins anew.
  void AddSums(PatchIntegrals& result) {
    if (!box_.has_value()) return;
    boxes_.AddTransposed(*box_, sums_[0],
                         [&](size_t i) -> Vec3d& { return result.volume_gradient[first_ + i]; });
    if (!result.moment_gradient.empty()) {
      for (size_t j = 0; j < 3; ++j) {
        boxes_.AddTransposed(*box_, sums_[j + 1], [&](size_t i) -> Vec3d& {
          return result.moment_gradient[first_ + i][j];
        });
      }
    }
    sums_ = {};
  }

 private:
  const BoxMaps boxes_;
  const size_t first_;
  const std::span<const Vec3d> control_points_;
  const Vec3d origin_;
  bool reaches_ = false;
  std::optional<size_t> box_;
  LocalMap map_{};
  BoxPolynomial polynomial_;
  std::array<double, 3> local_s_{}, local_t_{};  // of l, m, n
  BlockVec local_, values_;
  BlockSlopes slopes_;
  std::array<BoxNumbers, 4> sums_;  // of l^p m^q n^r w n dA in the box, then of that times P_j
};

class PatchSum {
 public:
  PatchSum(const DeformPlan& plan, std::span<const Vec3d> control_points, bool with_moment)
      : plan_(plan),
        with_moment_(with_moment),
        rule_(MakeTriangleRule(OrderFor(plan, with_moment))) {
    constexpr double kThird = 1.0 / 3;
    result_.origin =
        DirectFfd(plan, control_points).EvaluatePosition(0, {kThird, kThird, kThird}).position;
    result_.volume_gradient.resize(control_points.size());
    if (with_moment) result_.moment_gradient.resize(control_points.size());
    summands_.emplace_back(plan.structure, control_points, 0, result_.origin);
    for (const TurnedLattice& lattice : plan.turned) {
      summands_.emplace_back(lattice.structure, control_points, lattice.first_point,
                             result_.origin);
    }
  }

  absl::StatusOr<PatchIntegrals> Run(StopCheck stop) {
    constexpr size_t kCost = 32;  // a patch takes as long as so many in planning
    StopPoll poll(stop);
    for (size_t p = 0; p < plan_.patches.size(); ++p) {
      LATTICED_RETURN_IF_ERROR(poll.Step(kCost));
      AddPatch(p);
    }
    for (Summand& summand : summands_) summand.AddSums(result_);
    return std::move(result_);
  }

 private:
  // A rule of order m is exact to the degree 2 m - 2.
  static int OrderFor(const DeformPlan& plan, bool with_moment) {
    const int degree = plan.surface_degree();
    return with_moment ? 2 * degree : (3 * degree + 1) / 2;
  }

  IntegratedPatch PatchOf(size_t p) const {
    const auto& v = plan_.patches[p].vertex;
    IntegratedPatch patch{.corner = plan_.vertices[v[0]].world - result_.origin};
    patch.s = plan_.vertices[v[1]].world - result_.origin - patch.corner;
    patch.t = plan_.vertices[v[2]].world - result_.origin - patch.corner;
    if (plan_.is_weighted()) {
      const std::array<double, 3> weights = plan_.CornerWeights(p);
      patch.weight = weights[0];
      patch.weight_s = weights[1] - weights[0];
      patch.weight_t = weights[2] - weights[0];
    }
    return patch;
  }
  KnotSpans SpansOf(size_t summand, size_t p) const {
    if (summand > 0) return plan_.turned[summand - 1].spans[p];
    const uint32_t box = plan_.patches[p].box;
    return box == plan_.outside_box() ? kNoSpans : plan_.boxes[box].span;
  }

  void AddPatch(size_t p) {
    const IntegratedPatch patch = PatchOf(p);
    bool moves = false;
    for (size_t g = 0; g < summands_.size(); ++g) {
      summands_[g].Take(patch, SpansOf(g, p), result_);
      moves = moves || summands_[g].reaches();
    }
    const bool has_weight = patch.weight != 0 || patch.weight_s != 0 || patch.weight_t != 0;
    if (!moves || !has_weight) return AddResting(patch);
    for (size_t first = 0; first < rule_.size(); first += kBlockPoints) {
      AddPoints(patch,
                std::span(rule_).subspan(first, std::min(kBlockPoints, rule_.size() - first)));
    }
  }

  // P . n is constant on a flat triangle.
  void AddResting(const IntegratedPatch& patch) {
    const double across = 0.5 * Dot(patch.corner, Cross(patch.s, patch.t));
    result_.volume += across / 3;
    result_.moment += 0.25 * across / 3 * (3 * patch.corner + patch.s + patch.t);
  }

  void AddPoints(const IntegratedPatch& patch, std::span<const TriangleRulePoint> rule) {
    for (size_t i = 0; i < rule.size(); ++i) {
      const auto& b = rule[i].barycentrics;
      Set(rest_, i, patch.corner + b[1] * patch.s + b[2] * patch.t);
      for (BlockVec& move : moves_) Set(move, i, {});
    }
    for (Summand& summand : summands_) {
      if (summand.reaches()) summand.AddMoves(patch, rest_, rule.size(), moves_);
    }
    for (size_t i = 0; i < rule.size(); ++i) AddPoint(patch, rule[i], i);
    const std::span<BlockVec> forces = std::span(forces_).first(with_moment_ ? 4 : 1);
    for (BlockVec& force : forces) {
      for (auto& component : force) {
        std::fill(component.begin() + static_cast<std::ptrdiff_t>(rule.size()), component.end(), 0);
      }
    }
    for (Summand& summand : summands_) {
      if (summand.reaches()) summand.AddForces(forces, rule.size());
    }
  }

  void AddPoint(const IntegratedPatch& patch, const TriangleRulePoint& point, size_t i) {
    const auto& b = point.barycentrics;
    const double w = patch.weight + b[1] * patch.weight_s + b[2] * patch.weight_t;
    const Vec3d move = At(moves_[0], i);
    const Vec3d s = patch.s + w * At(moves_[1], i) + patch.weight_s * move;
    const Vec3d t = patch.t + w * At(moves_[2], i) + patch.weight_t * move;
    const Vec3d position = At(rest_, i) + w * move;
    const Vec3d directed = 0.5 * point.weight * Cross(s, t);
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
  const bool with_moment_;
  const std::vector<TriangleRulePoint> rule_;
  PatchIntegrals result_;
  std::vector<Summand> summands_;
  BlockVec rest_;                   // of the present points
  std::array<BlockVec, 3> moves_;   // D, then its derivatives by s and t
  std::array<BlockVec, 4> forces_;  // w n dA, then that times P_j
};

}  // namespace

absl::StatusOr<PatchIntegrals> IntegratePatches(const DeformPlan& plan,
                                                std::span<const Vec3d> control_points,
                                                bool with_moment, StopCheck stop) {
  return PatchSum(plan, control_points, with_moment).Run(stop);
}

}  // namespace latticed
