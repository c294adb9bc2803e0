// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/direct_ffd.h"

#include <algorithm>

#include "core/ffd/bspline_basis.h"
#include "core/ffd/plan/knot_split.h"

namespace latticed {
namespace {

Vec3d Blend(std::array<Vec3d, 3> v, std::array<double, 3> b) {
  return b[0] * v[0] + b[1] * v[1] + b[2] * v[2];
}

constexpr std::array<double, 3> kCentroid{1.0 / 3, 1.0 / 3, 1.0 / 3};

VolumeView ViewOf(const LatticeStructure& s, std::span<const Vec3d> control_points) {
  VolumeView volume{.control_points = control_points.data()};
  for (size_t a = 0; a < 3; ++a) {
    volume.degree[a] = s.degree[a];
    volume.size[a] = s.size[a];
    volume.knots[a] = s.knots[a].data();
  }
  return volume;
}

}  // namespace

VolumePoint EvaluateVolume(const LatticeStructure& s, std::span<const Vec3d> control_points,
                           const std::array<int, 3>& span, Vec3d parameter) {
  return EvaluateVolume<true>(ViewOf(s, control_points), span.data(), parameter);
}

Vec3d EvaluateVolumePosition(const LatticeStructure& s, std::span<const Vec3d> control_points,
                             const std::array<int, 3>& span, Vec3d parameter) {
  return EvaluateVolume<false>(ViewOf(s, control_points), span.data(), parameter).position;
}

std::array<Vec3d, 3> ParameterByWorld(const LatticeStructure& structure) {
  const FrameMap map(structure);
  return {map.DirectionToParameter({1, 0, 0}), map.DirectionToParameter({0, 1, 0}),
          map.DirectionToParameter({0, 0, 1})};
}

std::optional<VolumePlace> FindVolumePlace(const LatticeStructure& s, Vec3d world) {
  return FindVolumePlace(s, FrameMap(s), world);
}

std::optional<VolumePlace> FindVolumePlace(const LatticeStructure& s, const FrameMap& map,
                                           Vec3d world) {
  VolumePlace place{.parameter = map.ToParameter(world)};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    const double begin = s.domain_begin(axis), end = s.domain_end(axis);
    const double snap = kPlaneSnap * (end - begin);
    double& p = place.parameter[axis];
    if (!(p >= begin - snap && p <= end + snap)) return std::nullopt;
    p = std::clamp(p, begin, end);
    place.span[a] = FindLowerSpan(s.knots[a].data(), s.degree[a], s.size[a], p);
  }
  return place;
}

DeformedPoint EvaluateWorld(const LatticeStructure& s, std::span<const Vec3d> control_points,
                            Vec3d world) {
  const auto place = FindVolumePlace(s, world);
  if (!place.has_value()) return {.position = world};
  const VolumePoint point = EvaluateVolume(s, control_points, place->span, place->parameter);
  DeformedPoint result{.position = point.position, .inside = true};
  WorldJacobian(point.derivatives, ParameterByWorld(s).data(), result.jacobian.data());
  return result;
}

DeformedPoint EvaluateWorld(const DeformPlan& plan, std::span<const Vec3d> control_points,
                            Vec3d world) {
  DeformedPoint point = EvaluateWorld(plan.structure, control_points, world);
  if (plan.turned.empty()) return point;
  const TurnedMove turned = TurnedMoveAt(plan.turned, control_points, world);
  point.position += turned.move;
  for (size_t axis = 0; axis < 3; ++axis) point.jacobian[axis] += turned.jacobian[axis];
  return point;
}

DirectFfd::DirectFfd(const DeformPlan& plan, std::span<const Vec3d> control_points)
    : plan_(plan),
      control_points_(control_points),
      parameter_by_world_(ParameterByWorld(plan.structure)),
      turned_(plan.turned, control_points) {}

DeformedPoint DirectFfd::EvaluatePosition(size_t patch, std::array<double, 3> b) const {
  const Patch& p = plan_.patches[patch];
  std::array<Vec3d, 3> world, parameter;
  for (size_t c = 0; c < 3; ++c) {
    world[c] = plan_.vertices[p.vertex[c]].world;
    parameter[c] = plan_.vertices[p.vertex[c]].parameter;
  }
  DeformedPoint result{.position = Blend(world, b)};
  const TurnedMove turned = turned_.OfPatch(patch, p.vertex, b, result.position);
  if (p.box != plan_.outside_box()) {
    const VolumePoint point = EvaluateVolume(plan_.structure, control_points_,
                                             plan_.boxes[p.box].span, Blend(parameter, b));
    result = {.position = point.position, .inside = true};
    WorldJacobian(point.derivatives, parameter_by_world_.data(), result.jacobian.data());
  }
  result.position += turned.move;
  for (size_t axis = 0; axis < 3; ++axis) result.jacobian[axis] += turned.jacobian[axis];
  if (plan_.is_weighted()) {
    const std::array<double, 3> w = plan_.CornerWeights(patch);
    Weigh(Blend(world, b), b[0] * w[0] + b[1] * w[1] + b[2] * w[2],
          plan_.PatchWeightGradient(patch), result.position, result.jacobian);
  }
  return result;
}

Vec3d DirectFfd::OnEdge(uint32_t box, const std::array<uint32_t, 2>& ends, double t) const {
  const PlanVertex &a = plan_.vertices[ends[0]], &b = plan_.vertices[ends[1]];
  const Vec3d world = (1 - t) * a.world + t * b.world;
  Vec3d position = world;
  if (box != plan_.outside_box()) {
    position = EvaluateVolumePosition(plan_.structure, control_points_, plan_.boxes[box].span,
                                      (1 - t) * a.parameter + t * b.parameter);
  }
  position += turned_.OnEdge(ends[0], ends[1], t, world);
  if (!plan_.is_weighted()) return position;
  const double weight = (1 - t) * plan_.vertex_weights[ends[0]] + t * plan_.vertex_weights[ends[1]];
  return world + weight * (position - world);
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

Vec3d DirectFfd::SubstituteNormal(size_t patch, Normal normal) const {
  const Vec3d rest = RestNormal(patch, kCentroid, normal);
  const CarriedNormal carried =
      CarryNormal(EvaluatePosition(patch, kCentroid).jacobian.data(), rest);
  if (carried.kappa <= kMaxNormalCondition) return carried.direction;
  const Vec3d unit = Unit(rest);
  return unit != Vec3d{} ? unit : RestFacetNormal(patch);
}

DirectFfd::SurfacePoint DirectFfd::Evaluate(size_t patch, std::array<double, 3> b,
                                            Normal normal) const {
  const DeformedPoint point = EvaluatePosition(patch, b);
  const CarriedNormal carried = CarryNormal(point.jacobian.data(), RestNormal(patch, b, normal));
  if (carried.kappa <= kMaxNormalCondition) {
    return {point.position, carried.direction, carried.kappa, false};
  }
  return {point.position, SubstituteNormal(patch, normal), carried.kappa, true};
}

}  // namespace latticed
