// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_bounds.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/bezier_box.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/stage_matrices.h"

namespace latticed {
namespace {

// Below this size of parts, 2^-64 of the patch, rounding decides.
constexpr int kMostHalvings = 64;

// A coordinate on a part of a patch as a Bezier triangle of degree n: coefficient of (i, j, n - i - j) at i (n + 1) + j.
class BezierTriangle {
 public:
  static constexpr size_t kMost = 3 * limits::kMaxDegree + 1;

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
        points_(points),
        degree_(plan.structure.patch_degree()),
        inverse_(InverseBernsteinMatrix(degree_)),
        samples_((*StageMatrices::Get(degree_, 1))->samples) {}

  absl::StatusOr<Bounds> Run(StopCheck stop) {
    StopPoll poll(stop);
    for (const PlanVertex& vertex : plan_.vertices) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      known_.Extend(vertex.box == plan_.outside_box() ? vertex.world
                                                      : At(vertex.box, vertex.parameter));
    }
    const Vec3d extent = known_.extent();
    slack_ = kBoundsTolerance * std::max({extent.x, extent.y, extent.z});
    for (const uint32_t root : tree_.roots()) {
      LATTICED_RETURN_IF_ERROR(Search(tree_.node(root), poll));
    }
    return known_;
  }

 private:
  Vec3d At(uint32_t box, Vec3d parameter) const {
    return EvaluateVolume(plan_.structure, points_, plan_.boxes[box].span, parameter).position;
  }
  bool IsKnown(const Bounds& hull) const {
    for (int a = 0; a < 3; ++a) {
      if (hull.max[a] > known_.max[a] + slack_ || hull.min[a] < known_.min[a] - slack_)
        return false;
    }
    return true;
  }

  absl::Status Search(const PatchTree::Node& node, StopPoll& poll) {
    // Outside pieces are flat: their corners are known.
    if (node.box == plan_.outside_box()) return absl::OkStatus();
    LATTICED_RETURN_IF_ERROR(poll.Step());
    if (IsKnown(RestrictVolume(plan_.structure, points_, plan_.boxes[node.box].span, node.lower,
                               node.upper)
                    .Hull())) {
      return absl::OkStatus();
    }
    for (uint32_t n = node.first; n < node.first + node.count; ++n) {
      LATTICED_RETURN_IF_ERROR(node.leaf ? SearchPatch(plan_.patches[n], poll)
                                         : Search(tree_.node(n), poll));
    }
    return absl::OkStatus();
  }

  absl::Status SearchPatch(const Patch& patch, StopPoll& poll) {
    std::array<Vec3d, 3> corner;
    Bounds bounds;
    for (size_t c = 0; c < 3; ++c) {
      corner[c] = plan_.vertices[patch.vertex[c]].parameter;
      bounds.Extend(corner[c]);
    }
    if (IsKnown(RestrictVolume(plan_.structure, points_, plan_.boxes[patch.box].span, bounds.min,
                               bounds.max)
                    .Hull())) {
      return absl::OkStatus();
    }
    std::vector<Vec3d> values;
    for (const auto& [i, j, k] : samples_) {
      values.push_back(
          At(patch.box, (i * corner[0] + j * corner[1] + k * corner[2]) / double(degree_)));
    }
    for (int axis = 0; axis < 3; ++axis) {
      LATTICED_RETURN_IF_ERROR(SearchAxis(values, axis, 1, known_.max[axis], poll));
      double least = -known_.min[axis];
      LATTICED_RETURN_IF_ERROR(SearchAxis(values, axis, -1, least, poll));
      known_.min[axis] = -least;
    }
    return absl::OkStatus();
  }

  // Raises `most` to the largest value of sign times a coordinate on the patch.
  absl::Status SearchAxis(const std::vector<Vec3d>& values, int axis, double sign, double& most,
                          StopPoll& poll) const {
    BezierTriangle whole(degree_);
    const size_t m = values.size();
    for (size_t row = 0; row < m; ++row) {
      double sum = 0;
      for (size_t column = 0; column < m; ++column) {
        sum += inverse_[column * m + row] * sign * values[column][axis];
      }
      whole.at(static_cast<size_t>(samples_[row][0]), static_cast<size_t>(samples_[row][1])) = sum;
    }
    std::vector<std::pair<BezierTriangle, int>> parts{{whole, 0}};
    while (!parts.empty()) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      const auto [part, halvings] = parts.back();
      parts.pop_back();
      if (part.Largest() <= most + slack_) continue;
      if (halvings > 0) most = std::max(most, part.LargestCorner());
      if (halvings == kMostHalvings) continue;
      for (const BezierTriangle& half : part.Halves()) {
        if (half.Largest() > most + slack_) parts.emplace_back(half, halvings + 1);
      }
    }
    return absl::OkStatus();
  }

  const DeformPlan& plan_;
  const PatchTree& tree_;
  const std::span<const Vec3d> points_;
  const int degree_;
  const std::vector<double> inverse_;
  const std::vector<std::array<int, 3>>& samples_;
  Bounds known_;
  double slack_ = 0;
};

}  // namespace

absl::StatusOr<Bounds> MeasureBounds(const DeformPlan& plan, const PatchTree& tree,
                                     std::span<const Vec3d> control_points, StopCheck stop) {
  return BoundsSearch(plan, tree, control_points).Run(stop);
}

}  // namespace latticed
