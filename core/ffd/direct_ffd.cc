// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/direct_ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/limits.h"
#include "core/ffd/bspline_basis.h"

namespace latticed {
namespace {

using Basis = std::array<double, limits::kMaxDegree + 1>;

std::array<Vec3d, 3> ParameterByWorld(const LatticeStructure& structure) {
  const FrameMap map(structure);
  return {map.DirectionToParameter({1, 0, 0}), map.DirectionToParameter({0, 1, 0}),
          map.DirectionToParameter({0, 0, 1})};
}

std::array<Vec3d, 3> WorldJacobian(const std::array<Vec3d, 3>& by_parameter,
                                   const std::array<Vec3d, 3>& parameter_by_world) {
  std::array<Vec3d, 3> jacobian;
  for (size_t c = 0; c < 3; ++c) {
    const Vec3d d = parameter_by_world[c];
    jacobian[c] = d.x * by_parameter[0] + d.y * by_parameter[1] + d.z * by_parameter[2];
  }
  return jacobian;
}

Vec3d Unit(Vec3d v) {
  // Scaled first: the squares of a tiny patch's normal would underflow.
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return {};
  const Vec3d scaled = v / largest;
  return scaled / Norm(scaled);
}

Vec3d Blend(std::array<Vec3d, 3> v, std::array<double, 3> b) {
  return b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
}

// A cofactor below this part of |J|^2 is rounding: J maps space to a line, and kappa means nothing.
constexpr double kRankTolerance = 1e-12;

constexpr std::array<double, 3> kCentroid{1.0 / 3, 1.0 / 3, 1.0 / 3};

}  // namespace

VolumePoint EvaluateVolume(const LatticeStructure& s, std::span<const Vec3d> control_points,
                           const std::array<int, 3>& span, Vec3d parameter) {
  std::array<Basis, 3> value{}, slope{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    const double* knots = s.knots[a].data();
    EvaluateBasis(knots, s.degree[a], span[a], parameter[axis], value[a].data());
    EvaluateBasisDerivatives(knots, s.degree[a], span[a], parameter[axis], slope[a].data());
  }
  // Relative to one control point, so that derivatives far from the origin, or of a collapsed
  // lattice, hold no rounding of its place.
  const Vec3d origin = control_points[static_cast<size_t>(
      s.Index(span[0] - s.degree[0], span[1] - s.degree[1], span[2] - s.degree[2]))];
  VolumePoint result;
  for (int k = 0; k <= s.degree[2]; ++k) {
    const auto kk = static_cast<size_t>(k);
    for (int j = 0; j <= s.degree[1]; ++j) {
      const auto jj = static_cast<size_t>(j);
      const int row =
          s.Index(span[0] - s.degree[0], span[1] - s.degree[1] + j, span[2] - s.degree[2] + k);
      Vec3d along, along_u;
      for (int i = 0; i <= s.degree[0]; ++i) {
        const Vec3d p = control_points[static_cast<size_t>(row + i)] - origin;
        along += value[0][static_cast<size_t>(i)] * p;
        along_u += slope[0][static_cast<size_t>(i)] * p;
      }
      result.position += (value[1][jj] * value[2][kk]) * along;
      result.derivatives[0] += (value[1][jj] * value[2][kk]) * along_u;
      result.derivatives[1] += (slope[1][jj] * value[2][kk]) * along;
      result.derivatives[2] += (value[1][jj] * slope[2][kk]) * along;
    }
  }
  result.position += origin;
  return result;
}

DeformedPoint EvaluateWorld(const LatticeStructure& s, std::span<const Vec3d> control_points,
                            Vec3d world) {
  const Vec3d parameter = FrameMap(s).ToParameter(world);
  std::array<int, 3> span{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    if (!(parameter[axis] >= s.domain_begin(axis) && parameter[axis] <= s.domain_end(axis))) {
      return {.position = world};
    }
    span[a] = FindLowerSpan(s.knots[a].data(), s.degree[a], s.size[a], parameter[axis]);
  }
  const VolumePoint point = EvaluateVolume(s, control_points, span, parameter);
  return {point.position, WorldJacobian(point.derivatives, ParameterByWorld(s)), true};
}

Vec3d ApplyCofactor(const std::array<Vec3d, 3>& j, Vec3d n) {
  return n.x * Cross(j[1], j[2]) + n.y * Cross(j[2], j[0]) + n.z * Cross(j[0], j[1]);
}

double CofactorNorm(const std::array<Vec3d, 3>& j) {
  const Vec3d a = Cross(j[1], j[2]), b = Cross(j[2], j[0]), c = Cross(j[0], j[1]);
  return std::sqrt(Dot(a, a) + Dot(b, b) + Dot(c, c));
}

DirectFfd::DirectFfd(const DeformPlan& plan, std::span<const Vec3d> control_points)
    : plan_(plan),
      control_points_(control_points),
      parameter_by_world_(ParameterByWorld(plan.structure)) {}

DeformedPoint DirectFfd::EvaluatePosition(size_t patch, std::array<double, 3> b) const {
  const Patch& p = plan_.patches[patch];
  std::array<Vec3d, 3> world, parameter;
  for (size_t c = 0; c < 3; ++c) {
    world[c] = plan_.vertices[p.vertex[c]].world;
    parameter[c] = plan_.vertices[p.vertex[c]].parameter;
  }
  if (p.box == plan_.outside_box()) return {.position = Blend(world, b)};
  const VolumePoint point = EvaluateVolume(plan_.structure, control_points_,
                                           plan_.boxes[p.box].span, Blend(parameter, b));
  return {point.position, WorldJacobian(point.derivatives, parameter_by_world_), true};
}

Vec3d DirectFfd::RestFacetNormal(size_t patch) const {
  const PatchSource& source = plan_.sources[patch];
  const PolygonMesh& mesh = *plan_.mesh;
  std::array<Vec3d, 3> x;
  for (size_t c = 0; c < 3; ++c) x[c] = mesh.positions[mesh.corner_vertices[source.corners[c]]];
  Vec3d normal = Unit(Cross(x[1] - x[0], x[2] - x[0]));
  if (normal != Vec3d{}) return normal;
  for (size_t c = 0; c < 3; ++c) x[c] = plan_.vertices[plan_.patches[patch].vertex[c]].world;
  normal = Unit(Cross(x[1] - x[0], x[2] - x[0]));
  return normal != Vec3d{} ? normal : Vec3d{0, 0, 1};
}

Vec3d DirectFfd::RestSmoothNormal(size_t patch, std::array<double, 3> b) const {
  const PatchSource& source = plan_.sources[patch];
  Vec3d normal;
  for (size_t k = 0; k < 3; ++k) {
    double weight = 0;
    for (size_t c = 0; c < 3; ++c) weight += b[c] * source.barycentrics[c][k];
    normal += weight * ToDouble(plan_.vertex_normals[source.corners[k]]);
  }
  return normal;
}

Vec3d DirectFfd::RestNormal(size_t patch, std::array<double, 3> b, Normal normal) const {
  return normal == Normal::kFacet ? RestFacetNormal(patch) : RestSmoothNormal(patch, b);
}

DirectFfd::Carried DirectFfd::Carry(const DeformedPoint& point, Vec3d rest_normal) {
  const Vec3d carried = ApplyCofactor(point.jacobian, rest_normal);
  const double length = Norm(carried);
  const double cofactor = CofactorNorm(point.jacobian);
  const double kappa = cofactor * Norm(rest_normal) / length;
  double size2 = 0;
  for (const Vec3d& column : point.jacobian) size2 += Dot(column, column);
  if (!(length > 0) || !std::isfinite(kappa) || !(cofactor > kRankTolerance * size2)) {
    return {{}, std::numeric_limits<double>::infinity()};
  }
  return {Unit(carried), kappa};
}

Vec3d DirectFfd::SubstituteNormal(size_t patch, Normal normal) const {
  const Vec3d rest = RestNormal(patch, kCentroid, normal);
  const Carried carried = Carry(EvaluatePosition(patch, kCentroid), rest);
  if (carried.kappa <= kMaxNormalCondition) return carried.direction;
  const Vec3d unit = Unit(rest);
  return unit != Vec3d{} ? unit : RestFacetNormal(patch);
}

DirectFfd::SurfacePoint DirectFfd::Evaluate(size_t patch, std::array<double, 3> b,
                                            Normal normal) const {
  const DeformedPoint point = EvaluatePosition(patch, b);
  const Carried carried = Carry(point, RestNormal(patch, b, normal));
  if (carried.kappa <= kMaxNormalCondition) {
    return {point.position, carried.direction, carried.kappa, false};
  }
  return {point.position, SubstituteNormal(patch, normal), carried.kappa, true};
}

}  // namespace latticed
