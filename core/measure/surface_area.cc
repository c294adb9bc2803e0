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
  Vec3d in_patch;  // barycentrics
  Vec3d rest;
  double weight = 1;
};
using PatchPart = std::array<PartCorner, 3>;

PartCorner MiddleOf(const PartCorner& a, const PartCorner& b) {
  return {0.5 * (a.in_patch + b.in_patch), 0.5 * (a.rest + b.rest), 0.5 * (a.weight + b.weight)};
}

class AreaSum {
 public:
  AreaSum(const DeformPlan& plan, std::span<const Vec3d> control_points, double tolerance,
          bool with_gradient)
      : plan_(plan),
        control_points_(control_points),
        own_(ViewOf(plan.structure, control_points)),
        tolerance_(tolerance),
        coarse_(MakeTriangleRule(tolerance < kHighRules ? 4 : 2)),
        fine_(MakeTriangleRule(tolerance < kHighRules ? 6 : 4)) {
    if (with_gradient) result_.gradient.resize(control_points.size());
  }

  absl::StatusOr<SurfaceArea> Run(StopCheck stop) {
    StopPoll poll(stop);
    LATTICED_RETURN_IF_ERROR(Estimate(poll));
    for (size_t p = 0; p < plan_.patches.size(); ++p) {
      constexpr size_t kCost = 8;  // a patch takes as long as so many in planning
      LATTICED_RETURN_IF_ERROR(poll.Step(kCost));
      if (!TakePatch(p)) {
        result_.area += RestArea(p);
        continue;
      }
      // Half of the error in proportion to the area, half of it in proportion to the area at rest, where a patch is
      // folded.
      spare_ = 0.5 * tolerance_ * estimate_ * RestArea(p) / rest_area_;
      Add(PartOf(p), 0);
    }
    return std::move(result_);
  }

 private:
  // A lattice that reaches the present patch.
  struct Reaching {
    VolumeView volume;
    const int* span;                  // of the patch's box
    size_t first;                     // of its control points
    bool is_turned;                   // adds R - x
    std::array<Vec3d, 3> parameters;  // of the patch's corners
    std::array<Vec3d, 3> corners;     // the same of the present part's
  };
  static VolumeView ViewOf(const LatticeStructure& s, std::span<const Vec3d> control_points) {
    VolumeView volume{.control_points = control_points.data()};
    for (size_t a = 0; a < 3; ++a) {
      volume.degree[a] = s.degree[a];
      volume.size[a] = s.size[a];
      volume.knots[a] = s.knots[a].data();
    }
    return volume;
  }
  // Whether any lattice reaches the patch, which it makes the present one.
  bool TakePatch(size_t p) {
    reaching_.clear();
    const Patch& patch = plan_.patches[p];
    const auto parameters = [&](const auto& of) {
      return std::array{of(patch.vertex[0]), of(patch.vertex[1]), of(patch.vertex[2])};
    };
    if (patch.box != plan_.outside_box()) {
      reaching_.push_back({own_, plan_.boxes[patch.box].span.data(), 0, false,
                           parameters([&](uint32_t v) { return plan_.vertices[v].parameter; })});
    }
    for (const TurnedLattice& lattice : plan_.turned) {
      if (lattice.spans[p] == kNoSpans) continue;
      reaching_.push_back({ViewOf(lattice.structure, control_points_.subspan(lattice.first_point)),
                           lattice.spans[p].data(), lattice.first_point, true,
                           parameters([&](uint32_t v) { return lattice.parameters[v]; })});
    }
    return !reaching_.empty();
  }
  PatchPart PartOf(size_t p) const {
    PatchPart part;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = plan_.patches[p].vertex[c];
      part[c].in_patch[static_cast<int>(c)] = 1;
      part[c].rest = plan_.vertices[v].world;
      if (plan_.is_weighted()) part[c].weight = plan_.vertex_weights[v];
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
      if (!TakePatch(p)) {
        estimate_ += RestArea(p);
        continue;
      }
      const PatchPart part = PartOf(p);
      TakePart(part);
      estimate_ += Integrate(part, centroid);
    }
    return absl::OkStatus();
  }

  // Finds where the part is in the lattices that reach its patch.
  void TakePart(const PatchPart& part) {
    for (Reaching& lattice : reaching_) {
      lattice.corners = {};
      for (size_t c = 0; c < 3; ++c) {
        for (int i = 0; i < 3; ++i) {
          lattice.corners[c] += part[c].in_patch[i] * lattice.parameters[static_cast<size_t>(i)];
        }
      }
    }
  }
  static Vec3d Blend(const std::array<Vec3d, 3>& v, const std::array<double, 3>& b) {
    return b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
  }

  struct Tangents {
    Vec3d s, t;
    double weight = 1, weight_s = 0, weight_t = 0;
  };
  Tangents TangentsAt(const PatchPart& part, const std::array<double, 3>& b) const {
    const Vec3d rest_s = part[1].rest - part[0].rest, rest_t = part[2].rest - part[0].rest;
    Vec3d position;
    Tangents result;
    if (reaching_.front().is_turned) {  // the plan's own lattice leaves it at rest
      result = {.s = rest_s, .t = rest_t};
    }
    for (const Reaching& lattice : reaching_) {
      const std::array<Vec3d, 3>& corners = lattice.corners;
      const VolumePoint point =
          EvaluateVolume<true>(lattice.volume, lattice.span, Blend(corners, b));
      position += point.position;
      for (int a = 0; a < 3; ++a) {
        result.s += (corners[1] - corners[0])[a] * point.derivatives[a];
        result.t += (corners[2] - corners[0])[a] * point.derivatives[a];
      }
      if (!lattice.is_turned) continue;
      result.s -= rest_s;
      result.t -= rest_t;
    }
    if (plan_.is_weighted()) {
      const Vec3d rest = b[0] * part[0].rest + b[1] * part[1].rest + b[2] * part[2].rest;
      // The sum of what the lattices say holds the point at rest once for each of them.
      Weigh(part, b, position - static_cast<double>(reaching_.size()) * rest, result);
    }
    return result;
  }

  // Turns the derivatives of F at a point into those of P = x + w (F - x). `offset`: F - x.
  static void Weigh(const PatchPart& part, const std::array<double, 3>& b, Vec3d offset,
                    Tangents& at) {
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
    TakePart(part);
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
      const Vec3d by_value = 0.5 * weight * (at.weight_s * by_s + at.weight_t * by_t);
      for (const Reaching& lattice : reaching_) {
        const std::array<Vec3d, 3>& corners = lattice.corners;
        std::array<Vec3d, 3> by_axis;
        for (int a = 0; a < 3; ++a) {
          by_axis[static_cast<size_t>(a)] =
              0.5 * weight * at.weight *
              ((corners[1] - corners[0])[a] * by_s + (corners[2] - corners[0])[a] * by_t);
        }
        AddToPoints(lattice, Blend(corners, barycentrics), by_value, by_axis);
      }
    }
  }

  // Adds N_i by_value and the sum over a of dN_i/da by_axis[a] to each control point i of a lattice.
  void AddToPoints(const Reaching& lattice, Vec3d parameter, Vec3d by_value,
                   const std::array<Vec3d, 3>& by_axis) {
    const VolumeView& v = lattice.volume;
    std::array<std::array<double, limits::kMaxDegree + 1>, 3> value{}, slope{};
    std::array<int, 3> first{};
    for (size_t a = 0; a < 3; ++a) {
      const double at = parameter[static_cast<int>(a)];
      EvaluateBasis(v.knots[a], v.degree[a], lattice.span[a], at, value[a].data());
      EvaluateBasisDerivatives(v.knots[a], v.degree[a], lattice.span[a], at, slope[a].data());
      first[a] = lattice.span[a] - v.degree[a];
    }
    for (int k = 0; k <= v.degree[2]; ++k) {
      for (int j = 0; j <= v.degree[1]; ++j) {
        const auto jj = static_cast<size_t>(j), kk = static_cast<size_t>(k);
        const Vec3d by_u = value[1][jj] * value[2][kk] * by_axis[0];
        const Vec3d others = value[1][jj] * value[2][kk] * by_value +
                             slope[1][jj] * value[2][kk] * by_axis[1] +
                             value[1][jj] * slope[2][kk] * by_axis[2];
        const int row = first[0] + v.size[0] * (first[1] + j + v.size[1] * (first[2] + k));
        Vec3d* const gradient = &result_.gradient[lattice.first + static_cast<size_t>(row)];
        for (size_t i = 0; i <= static_cast<size_t>(v.degree[0]); ++i) {
          gradient[i] += slope[0][i] * by_u + value[0][i] * others;
        }
      }
    }
  }

  const DeformPlan& plan_;
  const std::span<const Vec3d> control_points_;
  const VolumeView own_;
  const double tolerance_;
  const std::vector<TriangleRulePoint> coarse_, fine_;
  std::vector<Reaching> reaching_;  // of the present patch; the plan's own lattice comes first
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
