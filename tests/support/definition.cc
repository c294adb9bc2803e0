// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/definition.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

#include "core/codec/chunk_encoder.h"
#include "core/codec/octahedral.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"

namespace latticed::testing {
namespace {

// Row sums of |Bqu inv(B)| at 10 segments, n = 3..10 (exact inverse). Differentiating the interpolant
// amplifies the rounding of its samples by this factor.
constexpr std::array<double, 8> kDerivativeRowSum{29, 69, 148, 303, 608, 1200, 2380, 4690};
// Samples, matrix and sums are each rounded to float. 8 half-units in the last place cover all three.
constexpr double kProductRounding = 8 * 0x1p-24;
// The rounding of the result itself.
constexpr double kResultRounding = 2 * 0x1p-24;

Bounds InfluencingControlPoints(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  Bounds bounds;
  const LatticeStructure& s = plan.structure;
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    if (plan.box_patches[b] == plan.box_patches[b + 1]) continue;
    const auto& span = plan.boxes[b].span;
    for (int k = span[2] - s.degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0]; ++i) {
          bounds.Extend(control_points[static_cast<size_t>(s.Index(i, j, k))]);
        }
      }
    }
  }
  return bounds;
}

// The error of each derivative is kProductRounding times the row sum times the extent of the samples.
// Twice the diagonal of the patch's points bounds that extent, since the points may skip a bulge.
double GemmNormalBound(const DeformPlan& plan, const DirectFfd& direct, size_t patch,
                       std::array<double, 3> barycentrics, DirectFfd::Normal kind,
                       double patch_diagonal) {
  const Patch& p = plan.patches[patch];
  const std::array<Vec3d, 3>& j = direct.EvaluatePosition(patch, barycentrics).jacobian;
  const auto carry = [&](Vec3d d) { return d.x * j[0] + d.y * j[1] + d.z * j[2]; };
  const Vec3d corner = plan.vertices[p.vertex[0]].world;
  const Vec3d e1 = plan.vertices[p.vertex[1]].world - corner;
  const Vec3d e2 = plan.vertices[p.vertex[2]].world - corner;
  const Vec3d f = direct.RestFacetNormal(patch);
  const Vec3d pu = carry(e1), pv = carry(e2), pf = carry(f);
  const auto n = static_cast<size_t>(plan.surface_degree());
  const double error = kProductRounding * kDerivativeRowSum[n - 3] * 2 * patch_diagonal;
  if (kind == DirectFfd::Normal::kFacet) {
    return error * (Norm(pu) + Norm(pv)) / Norm(Cross(pu, pv));
  }
  // pf is interpolated, not differentiated. Its error is like a position's, with its own extent.
  const double error_f = kProductRounding * 32 * (Norm(pf) + CofactorNorm(j));
  const Vec3d normal = direct.RestSmoothNormal(patch, barycentrics);
  const double by_f = Dot(normal, f), by_1 = Dot(normal, e1), by_2 = Dot(normal, e2);
  const Vec3d sum = by_f * Cross(pu, pv) + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu);
  const double turned = std::abs(by_f) * error * (Norm(pu) + Norm(pv)) +
                        std::abs(by_1) * (error * Norm(pf) + error_f * Norm(pv)) +
                        std::abs(by_2) * (error * Norm(pf) + error_f * Norm(pu));
  return turned / Norm(sum);
}

}  // namespace

double Angle(Vec3d a, Vec3d b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

std::vector<ViewPoint> DecodePoints(const DeformPlan& plan, const ViewSpec& spec,
                                    const QuantisationBox& box, std::span<const uint8_t> bytes) {
  std::vector<ViewPoint> points(bytes.size() / BytesPerPoint(spec));
  const bool normals = spec.normals != NormalMode::kNone;
  if (spec.format == VertexFormat::kFloat32) {
    for (size_t i = 0; i < points.size(); ++i) {
      std::array<Vec3f, 2> v{};
      std::memcpy(v.data(), &bytes[i * BytesPerPoint(spec)], BytesPerPoint(spec));
      points[i] = {plan.local_origin + ToDouble(v[0]), ToDouble(v[1])};
    }
    return points;
  }
  const auto v = QuantisedVertices::FromBytes(bytes, points.size(), spec.position_bits,
                                              normals ? spec.normal_bits : 0);
  const auto code = [&](const uint8_t* values, size_t i) {
    return spec.normal_bits <= 8 ? int32_t{values[i]} : values[2 * i] | values[2 * i + 1] << 8;
  };
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec3d steps{double(v.x[i]), double(v.y[i]), double(v.z[i])};
    points[i].position = box.origin + box.step(spec.position_bits) * steps;
    if (!normals) continue;
    points[i].normal = ToDouble(DequantiseNormal({code(v.s, i), code(v.t, i)}, spec.normal_bits));
  }
  return points;
}

RoundingTolerance RoundingOf(const ViewSpec& spec, const QuantisationBox& box) {
  if (spec.format == VertexFormat::kFloat32) return {};
  return {.position = std::numbers::sqrt3 * 0.5 * box.step(spec.position_bits),
          .normal = 2.0 * std::sqrt(6.0) / OctahedralMax(spec.normal_bits)};
}

Definition::Definition(const DeformPlan& plan, std::span<const Vec3d> control_points, int segments,
                       NormalMode normals, std::vector<uint32_t> patches,
                       const PointOfPatch& deformation)
    : plan_(plan),
      direct_(plan, control_points),
      normals_(normals),
      kind_(normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth
                                           : DirectFfd::Normal::kFacet),
      patches_(std::move(patches)) {
  const double over = 1.0 / segments;
  for (const auto& t : TessellationPattern::Get(segments).points) {
    barycentrics_.push_back({t[0] * over, t[1] * over, t[2] * over});
  }
  Bounds deformed;
  for (const uint32_t p : patches_) {
    Bounds of_patch;
    for (const auto& b : barycentrics_) {
      points_.push_back(PointAt(deformation, p, b));
      of_patch.Extend(points_.back().position);
    }
    patch_diagonals_.push_back(of_patch.diagonal());
    deformed.Extend(of_patch);
  }
  scale_ = std::max(deformed.diagonal(), InfluencingControlPoints(plan, control_points).diagonal());
  // A surface collapsed to a point has no size. Then float32 must hold its distance from the origin.
  if (scale_ == 0) scale_ = Norm(deformed.center() - plan.local_origin);
}

// Where the normal would be replaced, nothing asks for it: its kappa is above kMostKappa.
DirectFfd::SurfacePoint Definition::PointAt(const PointOfPatch& deformation, size_t patch,
                                            const std::array<double, 3>& b) const {
  if (!deformation) return direct_.Evaluate(patch, b, kind_);
  const Vec3d rest = kind_ == DirectFfd::Normal::kSmooth ? direct_.RestSmoothNormal(patch, b)
                                                         : direct_.RestFacetNormal(patch);
  const DeformedPoint point = deformation(patch, b);
  const CarriedNormal carried = CarryNormal(point.jacobian.data(), rest);
  return {point.position, carried.direction, carried.kappa};
}

absl::Status Definition::Check(Pipeline pipeline, std::span<const ViewPoint> points,
                               RoundingTolerance rounding) const {
  if (points.size() != points_.size()) {
    return absl::InternalError(fmt::format("{} points, not {}", points.size(), points_.size()));
  }
  const double most_distance = PositionTolerance(pipeline) * scale_ + rounding.position;
  for (size_t at = 0; at < points.size(); ++at) {
    const size_t q = barycentrics_.size();
    const auto wrong = [&](const char* what, double by, double allowed) {
      return absl::InternalError(fmt::format("patch {} point {}: {} off by {:.3g}, allowed {:.3g}",
                                             patches_[at / q], at % q, what, by, allowed));
    };
    const double distance = Norm(points[at].position - points_[at].position);
    if (!(distance <= most_distance)) return wrong("position", distance, most_distance);
    if (normals_ == NormalMode::kNone) continue;
    const double length_error = std::abs(Norm(points[at].normal) - 1);
    if (!(length_error <= kUnitTolerance)) return wrong("length", length_error, kUnitTolerance);
    const double angle = Angle(points[at].normal, points_[at].normal);
    const double most_angle = NormalTolerance(pipeline, at) + rounding.normal;
    if (!(angle <= most_angle)) return wrong("normal", angle, most_angle);
  }
  return absl::OkStatus();
}

// Infinite where the definition's own normal is ill-conditioned.
double Definition::NormalTolerance(Pipeline pipeline, size_t at) const {
  const double kappa = points_[at].kappa;
  if (!(kappa <= kMostKappa)) return std::numeric_limits<double>::infinity();
  const size_t nth = at / barycentrics_.size();
  if (pipeline == Pipeline::kFused) {
    // A weight's gradient carries the error of a position to the normal.
    const double steepness =
        plan_.is_weighted() ? Norm(plan_.PatchWeightGradient(patches_[nth])) : 0.0;
    return (kFusedNormal + kFusedPosition * scale_ * steepness) * kappa;
  }
  return kResultRounding + GemmNormalBound(plan_, direct_, patches_[nth],
                                           barycentrics_[at % barycentrics_.size()], kind_,
                                           patch_diagonals_[nth]);
}

}  // namespace latticed::testing
