// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/box/bezier_box.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/stage_matrices.h"
#include "core/ffd/weights/weighted_triangle.h"
#include "core/measure/patch_points.h"
#include "core/measure/patch_runs.h"

namespace latticed {
namespace {

// Below this size of parts, 2^-64 of the patch, rounding decides.
constexpr int kMostBoundHalvings = 64;

// A coordinate on a part of a patch as a Bezier triangle of degree n: coefficient of (i, j, n - i - j) at i (n + 1) + j.
class BezierTriangle {
 public:
  static constexpr size_t kMost = 3 * limits::kMaxDegree + 2;  // of a patch with weights

  explicit BezierTriangle(int degree) : n_(static_cast<size_t>(degree)) {}
  double& at(size_t i, size_t j) { return c_[i * (n_ + 1) + j]; }
  double at(size_t i, size_t j) const { return c_[i * (n_ + 1) + j]; }

  double Largest() const {
    double largest = at(0, 0);
    for (size_t i = 0; i <= n_; ++i) {
      for (size_t j = 0; i + j <= n_; ++j) largest = std::max(largest, at(i, j));
    }
    return largest;
  }
  void Negate() {
    for (double& c : c_) c = -c;
  }
  double LargestCorner() const { return std::max({at(n_, 0), at(0, n_), at(0, 0)}); }

  // Splits the edge from corner 0 to corner 1. The new point becomes corner 2 of both halves, so that the edges of the
  // next split are those opposite to it.
  std::array<BezierTriangle, 2> Halves() const {
    std::array<BezierTriangle, 2> halves{BezierTriangle(*this), BezierTriangle(*this)};
    BezierTriangle level(*this);
    for (size_t r = 0; r <= n_; ++r) {
      const size_t left = n_ - r;
      for (size_t m = 0; m <= left; ++m) {
        // Of the halves' corners (2, 0, new) and (1, 2, new); r counts the new one.
        halves[0].at(left - m, m) = level.at(m, 0);
        halves[1].at(m, left - m) = level.at(0, m);
      }
      for (size_t i = 0; i < left; ++i) {
        for (size_t j = 0; i + j < left; ++j) {
          level.at(i, j) = 0.5 * (level.at(i + 1, j) + level.at(i, j + 1));
        }
      }
    }
    return halves;
  }

 private:
  size_t n_;
  std::array<double, kMost * kMost> c_{};
};

class BoundsSearch {
 public:
  BoundsSearch(const DeformPlan& plan, const PatchTree& tree, std::span<const Vec3d> points)
      : plan_(plan),
        tree_(tree),
        given_(points),
        points_(points.begin(), points.end()),
        frame_(plan.structure),
        degree_(plan.patch_degree()),
        inverse_(InverseBernsteinMatrix(degree_)),
        samples_((*StageMatrices::Get(degree_, 1))->samples) {
    for (size_t row = 0; row < samples_.size(); ++row) {
      TriangleRulePoint point;
      for (size_t c = 0; c < 3; ++c) point.barycentrics[c] = samples_[row][c] / double(degree_);
      sample_points_.push_back(point);
      double sum = 0;
      for (size_t column = 0; column < samples_.size(); ++column) {
        sum += std::abs(inverse_[column * samples_.size() + row]);
      }
      reach_ = std::max(reach_, sum);
    }
    if (!plan.is_weighted()) return;
    for (size_t i = 0; i < points.size(); ++i) points_[i] -= plan.identity_points[i];
  }

  absl::StatusOr<Bounds> Run(StopCheck stop, CpuArena* arena) {
    StopPoll poll(stop);
    if (!plan_.turned.empty()) return RunUnderTurned(stop, arena);
    for (size_t v = 0; v < plan_.vertices.size(); ++v) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      known_.Extend(PositionOf(v));
    }
    SetSlack();
    for (const uint32_t root : tree_.roots()) {
      LATTICED_RETURN_IF_ERROR(Search(tree_.node(root), poll));
    }
    return known_;
  }

 private:
  Vec3d At(uint32_t box, Vec3d parameter) const {
    return EvaluateVolume(plan_.structure, points_, plan_.boxes[box].span, parameter).position;
  }
  Vec3d PositionOf(size_t v) const {
    const PlanVertex& vertex = plan_.vertices[v];
    if (vertex.box == plan_.outside_box()) return vertex.world;
    const Vec3d at = At(vertex.box, vertex.parameter);
    return plan_.is_weighted() ? vertex.world + plan_.vertex_weights[v] * at : at;
  }
  // Of F, or with weights of the offset F - x, on a part of a knot box.
  Bounds HullOf(uint32_t box, Vec3d lower, Vec3d upper) const {
    return RestrictVolume(plan_.structure, points_, plan_.boxes[box].span, lower, upper).Hull();
  }
  Bounds HullOf(const PatchTree::Node& node) const {
    const Bounds hull = HullOf(node.box, node.lower, node.upper);
    if (!plan_.is_weighted()) return hull;
    Bounds rest;
    for (int corner = 0; corner < 8; ++corner) {
      rest.Extend(frame_.ToWorld({(corner & 1) != 0 ? node.upper.x : node.lower.x,
                                  (corner & 2) != 0 ? node.upper.y : node.lower.y,
                                  (corner & 4) != 0 ? node.upper.z : node.lower.z}));
    }
    return WeightedHull(rest, hull, 0, 1);
  }
  bool IsKnown(const Bounds& hull) const { return IsIn(hull, known_); }
  bool IsIn(const Bounds& hull, const Bounds& known) const {
    for (int a = 0; a < 3; ++a) {
      if (hull.max[a] > known.max[a] + slack_ || hull.min[a] < known.min[a] - slack_) return false;
    }
    return true;
  }

  absl::Status Search(const PatchTree::Node& node, StopPoll& poll) {
    // Outside pieces are flat: their corners are known.
    if (node.box == plan_.outside_box()) return absl::OkStatus();
    LATTICED_RETURN_IF_ERROR(poll.Step());
    if (IsKnown(HullOf(node))) return absl::OkStatus();
    for (uint32_t n = node.first; n < node.first + node.count; ++n) {
      LATTICED_RETURN_IF_ERROR(node.leaf ? SearchPatch(n, poll) : Search(tree_.node(n), poll));
    }
    return absl::OkStatus();
  }

  void SetSlack() {
    const Vec3d extent = known_.extent();
    slack_ = kBoundsTolerance * std::max({extent.x, extent.y, extent.z});
  }

  // Calls body(patch, values) for the patches of a run, with values of F at the samples, or with weights of F - x. Extends
  // `attained` by where they are.
  template <class Body>
  void ForSamples(const PatchRuns& runs, size_t run, Bounds& attained, const Body& body) const {
    const std::vector<RunLattice> lattices = runs.LatticesOf(run);
    const size_t together = PatchPoints::kMost / sample_points_.size();
    PatchPoints points(lattices);
    std::vector<Vec3d> values(sample_points_.size());
    for (auto left = runs.patches(run); !left.empty();) {
      const auto patches = left.first(std::min(left.size(), together));
      left = left.subspan(patches.size());
      points.Clear();
      for (const uint32_t patch : patches) points.Add(runs.TriangleOf(patch), sample_points_);
      points.Evaluate();
      for (size_t n = 0; n < patches.size(); ++n) {
        for (size_t i = 0; i < values.size(); ++i) {
          const size_t at = n * values.size() + i;
          const Vec3d position = runs.origin() + points.position(at);
          attained.Extend(position);
          values[i] = plan_.is_weighted() ? points.move(at) : position;
        }
        body(patches[n], values);
      }
    }
  }

  struct RunBounds {
    Bounds samples, hull;
  };
  // Looks at the samples of each patch: the boxes of the tree are those of one lattice alone.
  absl::StatusOr<Bounds> RunUnderTurned(StopCheck stop, CpuArena* arena) {
    const PatchRuns runs(plan_, given_);
    std::vector<Bounds> hulls;  // by run
    LATTICED_RETURN_IF_ERROR(ForRuns(
        runs, arena, stop,
        [&](size_t run) {
          RunBounds of_run;
          ForSamples(runs, run, of_run.samples,
                     [&](size_t patch, const std::vector<Vec3d>& values) {
                       of_run.hull.Extend(HullOf(patch, values));
                     });
          return of_run;
        },
        [&](const RunBounds& of_run) {
          known_.Extend(of_run.samples);
          hulls.push_back(of_run.hull);
        }));
    SetSlack();
    // Each run begins with what the samples tell, so that none waits for another.
    const Bounds of_samples = known_;
    LATTICED_RETURN_IF_ERROR(ForRuns(
        runs, arena, stop,
        [&](size_t run) {
          Bounds known = of_samples;
          if (IsIn(hulls[run], known)) return known;
          StopPoll never(NeverStop);
          ForSamples(runs, run, known, [&](size_t patch, const std::vector<Vec3d>& values) {
            if (!IsIn(HullOf(patch, values), known)) {
              SearchAxes(values, patch, known, never).IgnoreError();
            }
          });
          return known;
        },
        [&](const Bounds& known) { known_.Extend(known); }, 1));
    return known_;
  }

  // Holds a patch, loosely: from the middle of its samples no Bezier control point is farther than reach_ times their
  // farthest, since the rows of the inverse Bernstein matrix sum to 1.
  Bounds HullOf(size_t patch, const std::vector<Vec3d>& values) const {
    Bounds samples;
    for (const Vec3d value : values) samples.Extend(value);
    const Vec3d middle = 0.5 * (samples.min + samples.max);
    const Vec3d farthest = 0.5 * reach_ * samples.extent();
    const Bounds hull{middle - farthest, middle + farthest};
    return plan_.is_weighted() ? TriangleOf(patch).Hull(hull) : hull;
  }

  // The plan must be weighted.
  WeightedTriangle TriangleOf(size_t p) const {
    WeightedTriangle triangle{.weight = plan_.CornerWeights(p)};
    for (size_t c = 0; c < 3; ++c) {
      triangle.rest[c] = plan_.vertices[plan_.patches[p].vertex[c]].world;
    }
    return triangle;
  }

  absl::Status SearchPatch(size_t p, StopPoll& poll) {
    const Patch& patch = plan_.patches[p];
    std::array<Vec3d, 3> corner;
    Bounds bounds;
    for (size_t c = 0; c < 3; ++c) {
      corner[c] = plan_.vertices[patch.vertex[c]].parameter;
      bounds.Extend(corner[c]);
    }
    const Bounds hull = HullOf(patch.box, bounds.min, bounds.max);
    if (IsKnown(plan_.is_weighted() ? TriangleOf(p).Hull(hull) : hull)) return absl::OkStatus();
    std::vector<Vec3d> values;
    for (const auto& [i, j, k] : samples_) {
      values.push_back(
          At(patch.box, (i * corner[0] + j * corner[1] + k * corner[2]) / double(degree_)));
    }
    return SearchAxes(values, p, known_, poll);
  }

  // `values` of F at the samples of a patch, or with weights of F - x.
  absl::Status SearchAxes(const std::vector<Vec3d>& values, size_t p, Bounds& known,
                          StopPoll& poll) const {
    for (int axis = 0; axis < 3; ++axis) {
      BezierTriangle patch_axis = Interpolated(values, axis);
      if (plan_.is_weighted()) patch_axis = Weighted(patch_axis, TriangleOf(p), axis);
      LATTICED_RETURN_IF_ERROR(SearchBothWays(patch_axis, axis, known, poll));
    }
    return absl::OkStatus();
  }

  absl::Status SearchBothWays(BezierTriangle patch_axis, int axis, Bounds& known,
                              StopPoll& poll) const {
    LATTICED_RETURN_IF_ERROR(SearchAxis(patch_axis, known.max[axis], poll));
    double least = -known.min[axis];
    patch_axis.Negate();
    LATTICED_RETURN_IF_ERROR(SearchAxis(patch_axis, least, poll));
    known.min[axis] = -least;
    return absl::OkStatus();
  }

  BezierTriangle Interpolated(const std::vector<Vec3d>& values, int axis) const {
    BezierTriangle whole(degree_);
    const size_t m = values.size();
    for (size_t row = 0; row < m; ++row) {
      double sum = 0;
      for (size_t column = 0; column < m; ++column) {
        sum += inverse_[column * m + row] * values[column][axis];
      }
      whole.at(static_cast<size_t>(samples_[row][0]), static_cast<size_t>(samples_[row][1])) = sum;
    }
    return whole;
  }

  // x + w (F - x), one degree higher, from F - x.
  BezierTriangle Weighted(const BezierTriangle& offset, const WeightedTriangle& triangle,
                          int axis) const {
    const auto n = static_cast<size_t>(degree_) + 1;
    BezierTriangle whole(degree_ + 1);
    for (size_t i = 0; i <= n; ++i) {
      for (size_t j = 0; i + j <= n; ++j) {
        const std::array<size_t, 3> power{i, j, n - i - j};
        double sum = 0;
        for (size_t c = 0; c < 3; ++c) {
          if (power[c] == 0) continue;
          const double before = offset.at(i - (c == 0 ? 1 : 0), j - (c == 1 ? 1 : 0));
          sum += static_cast<double>(power[c]) *
                 (triangle.rest[c][axis] + triangle.weight[c] * before);
        }
        whole.at(i, j) = sum / static_cast<double>(n);
      }
    }
    return whole;
  }

  // Raises `most` to the largest value on the patch.
  absl::Status SearchAxis(const BezierTriangle& whole, double& most, StopPoll& poll) const {
    std::vector<std::pair<BezierTriangle, int>> parts{{whole, 0}};
    while (!parts.empty()) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      const auto [part, halvings] = parts.back();
      parts.pop_back();
      if (part.Largest() <= most + slack_) continue;
      if (halvings > 0) most = std::max(most, part.LargestCorner());
      if (halvings == kMostBoundHalvings) continue;
      for (const BezierTriangle& half : part.Halves()) {
        if (half.Largest() > most + slack_) parts.emplace_back(half, halvings + 1);
      }
    }
    return absl::OkStatus();
  }

  const DeformPlan& plan_;
  const PatchTree& tree_;
  const std::span<const Vec3d> given_;  // control points
  std::vector<Vec3d> points_;           // with weights, the offsets of control points
  const FrameMap frame_;
  const int degree_;
  const std::vector<double> inverse_;
  const std::vector<std::array<int, 3>>& samples_;
  std::vector<TriangleRulePoint> sample_points_;
  double reach_ = 0;  // the largest sum of sizes in a row of the inverse Bernstein matrix
  Bounds known_;
  double slack_ = 0;
};

}  // namespace

absl::StatusOr<Bounds> MeasureBounds(const DeformPlan& plan, const PatchTree& tree,
                                     std::span<const Vec3d> control_points, StopCheck stop,
                                     CpuArena* arena) {
  return BoundsSearch(plan, tree, control_points).Run(stop, arena);
}

}  // namespace latticed
