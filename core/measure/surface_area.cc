// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_area.h"

#include <array>
#include <cmath>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/box/volume_point.h"
#include "core/ffd/bspline_basis.h"
#include "core/measure/triangle_rule.h"

namespace latticed {
namespace {

constexpr int kMostQuarterings = 24;
// Above this tolerance two low rules need the fewest points, below it two higher ones.
constexpr double kHighRules = 1e-7;

// A part of a patch by its corners.
struct PartCorner {
  Vec3d parameter, rest;
  double weight = 1;
};
using PatchPart = std::array<PartCorner, 3>;

PartCorner MiddleOf(const PartCorner& a, const PartCorner& b) {
  return {0.5 * (a.parameter + b.parameter), 0.5 * (a.rest + b.rest), 0.5 * (a.weight + b.weight)};
}

class AreaSum {
 public:
  AreaSum(const DeformPlan& plan, std::span<const Vec3d> control_points, double tolerance,
          bool with_gradient)
      : plan_(plan),
        tolerance_(tolerance),
        coarse_(MakeTriangleRule(tolerance < kHighRules ? 4 : 2)),
        fine_(MakeTriangleRule(tolerance < kHighRules ? 6 : 4)) {
    const LatticeStructure& s = plan.structure;
    for (size_t a = 0; a < 3; ++a) {
      volume_.degree[a] = s.degree[a];
      volume_.size[a] = s.size[a];
      volume_.knots[a] = s.knots[a].data();
    }
    volume_.control_points = control_points.data();
    if (with_gradient) result_.gradient.resize(control_points.size());
  }

  absl::StatusOr<SurfaceArea> Run(StopCheck stop) {
    StopPoll poll(stop);
    LATTICED_RETURN_IF_ERROR(Estimate(poll));
    for (size_t p = 0; p < plan_.patches.size(); ++p) {
      constexpr size_t kCost = 8;  // a patch takes as long as so many in planning
      LATTICED_RETURN_IF_ERROR(poll.Step(kCost));
      if (IsOutside(p)) {
        result_.area += RestArea(p);
        continue;
      }
      span_ = plan_.boxes[plan_.patches[p].box].span.data();
      // Half of the error in proportion to the area, half of it in proportion to the area at rest, where a patch is
      // folded.
      spare_ = 0.5 * tolerance_ * estimate_ * RestArea(p) / rest_area_;
      Add(PartOf(p), 0);
    }
    return std::move(result_);
  }

 private:
  bool IsOutside(size_t p) const { return plan_.patches[p].box == plan_.outside_box(); }
  PatchPart PartOf(size_t p) const {
    PatchPart part;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = plan_.patches[p].vertex[c];
      part[c] = {plan_.vertices[v].parameter, plan_.vertices[v].world,
                 plan_.is_weighted() ? plan_.vertex_weights[v] : 1};
    }
    return part;
  }
  double RestArea(size_t p) const {
    const auto& v = plan_.patches[p].vertex;
    const Vec3d a = plan_.vertices[v[0]].world;
    return 0.5 * Norm(Cross(plan_.vertices[v[1]].world - a, plan_.vertices[v[2]].world - a));
  }

  // A first estimate of the whole area, by one point a patch.
  absl::Status Estimate(StopPoll& poll) {
    const auto centroid = MakeTriangleRule(1);
    for (size_t p = 0; p < plan_.patches.size(); ++p) {
      LATTICED_RETURN_IF_ERROR(poll.Step());
      rest_area_ += RestArea(p);
      if (IsOutside(p)) {
        estimate_ += RestArea(p);
        continue;
      }
      span_ = plan_.boxes[plan_.patches[p].box].span.data();
      estimate_ += Integrate(PartOf(p), centroid);
    }
    return absl::OkStatus();
  }

  struct Tangents {
    Vec3d parameter, s, t;
    double weight = 1, weight_s = 0, weight_t = 0;
  };
  Tangents TangentsAt(const PatchPart& part, const std::array<double, 3>& b) const {
    const Vec3d place =
        b[0] * part[0].parameter + b[1] * part[1].parameter + b[2] * part[2].parameter;
    const VolumePoint point = EvaluateVolume<true>(volume_, span_, place);
    Tangents result{.parameter = place};
    for (int a = 0; a < 3; ++a) {
      result.s += (part[1].parameter - part[0].parameter)[a] * point.derivatives[a];
      result.t += (part[2].parameter - part[0].parameter)[a] * point.derivatives[a];
    }
    if (plan_.is_weighted()) Weigh(part, b, point.position, result);
    return result;
  }

  // Turns the derivatives of F at a point into those of P = x + w (F - x).
  static void Weigh(const PatchPart& part, const std::array<double, 3>& b, Vec3d position,
                    Tangents& at) {
    const Vec3d offset =
        position - (b[0] * part[0].rest + b[1] * part[1].rest + b[2] * part[2].rest);
    const Vec3d rest_s = part[1].rest - part[0].rest, rest_t = part[2].rest - part[0].rest;
    at.weight = b[0] * part[0].weight + b[1] * part[1].weight + b[2] * part[2].weight;
    at.weight_s = part[1].weight - part[0].weight;
    at.weight_t = part[2].weight - part[0].weight;
    at.s = rest_s + at.weight * (at.s - rest_s) + at.weight_s * offset;
    at.t = rest_t + at.weight * (at.t - rest_t) + at.weight_t * offset;
  }

  double Integrate(const PatchPart& part, const std::vector<TriangleRulePoint>& rule) const {
    double sum = 0;
    for (const auto& [barycentrics, weight] : rule) {
      const Tangents at = TangentsAt(part, barycentrics);
      sum += 0.5 * weight * Norm(Cross(at.s, at.t));
    }
    return sum;
  }

  void Add(const PatchPart& part, int quarterings) {
    const double area = Integrate(part, fine_);
    const double error = std::abs(area - Integrate(part, coarse_));
    if (error <= 0.5 * tolerance_ * area + std::ldexp(spare_, -2 * quarterings) ||
        quarterings == kMostQuarterings) {
      result_.area += area;
      result_.error += error;
      if (!result_.gradient.empty()) AddGradient(part);
      return;
    }
    const PartCorner a = MiddleOf(part[1], part[2]), b = MiddleOf(part[2], part[0]),
                     c = MiddleOf(part[0], part[1]);
    for (const PatchPart& quarter : {PatchPart{part[0], c, b}, PatchPart{c, part[1], a},
                                     PatchPart{b, a, part[2]}, PatchPart{a, b, c}}) {
      Add(quarter, quarterings + 1);
    }
  }

  void AddGradient(const PatchPart& part) {
    for (const auto& [barycentrics, weight] : fine_) {
      const Tangents at = TangentsAt(part, barycentrics);
      const Vec3d normal = Cross(at.s, at.t);
      const double length = Norm(normal);
      if (!(length > 0)) continue;  // no direction: half of the surface's kink
      const Vec3d unit = normal / length;
      const Vec3d by_s = Cross(at.t, unit), by_t = Cross(unit, at.s);
      std::array<Vec3d, 3> by_axis;
      for (int a = 0; a < 3; ++a) {
        by_axis[static_cast<size_t>(a)] = 0.5 * weight * at.weight *
                                          ((part[1].parameter - part[0].parameter)[a] * by_s +
                                           (part[2].parameter - part[0].parameter)[a] * by_t);
      }
      AddToPoints(at.parameter, 0.5 * weight * (at.weight_s * by_s + at.weight_t * by_t), by_axis);
    }
  }

  // Adds N_i by_value and the sum over a of dN_i/da by_axis[a] to each control point i.
  void AddToPoints(Vec3d parameter, Vec3d by_value, const std::array<Vec3d, 3>& by_axis) {
    std::array<std::array<double, limits::kMaxDegree + 1>, 3> value{}, slope{};
    for (size_t a = 0; a < 3; ++a) {
      EvaluateBasis(volume_.knots[a], volume_.degree[a], span_[a], parameter[static_cast<int>(a)],
                    value[a].data());
      EvaluateBasisDerivatives(volume_.knots[a], volume_.degree[a], span_[a],
                               parameter[static_cast<int>(a)], slope[a].data());
    }
    for (int k = 0; k <= volume_.degree[2]; ++k) {
      for (int j = 0; j <= volume_.degree[1]; ++j) {
        const auto jj = static_cast<size_t>(j), kk = static_cast<size_t>(k);
        const Vec3d by_u = value[1][jj] * value[2][kk] * by_axis[0];
        const Vec3d others = value[1][jj] * value[2][kk] * by_value +
                             slope[1][jj] * value[2][kk] * by_axis[1] +
                             value[1][jj] * slope[2][kk] * by_axis[2];
        for (int i = 0; i <= volume_.degree[0]; ++i) {
          const auto ii = static_cast<size_t>(i);
          result_.gradient[static_cast<size_t>(plan_.structure.Index(
              span_[0] - volume_.degree[0] + i, span_[1] - volume_.degree[1] + j,
              span_[2] - volume_.degree[2] + k))] += slope[0][ii] * by_u + value[0][ii] * others;
        }
      }
    }
  }

  const DeformPlan& plan_;
  const double tolerance_;
  const std::vector<TriangleRulePoint> coarse_, fine_;
  VolumeView volume_;
  const int* span_ = nullptr;  // of the present patch's box
  double estimate_ = 0, rest_area_ = 0, spare_ = 0;
  SurfaceArea result_;
};

}  // namespace

absl::StatusOr<SurfaceArea> MeasureArea(const DeformPlan& plan,
                                        std::span<const Vec3d> control_points, double tolerance,
                                        bool with_gradient, StopCheck stop) {
  return AreaSum(plan, control_points, tolerance, with_gradient).Run(stop);
}

}  // namespace latticed
