// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// EvaluatePoints: the deformation in double precision, straight from its definition, at points of the surface or
// of undeformed space.
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "server/wire/scene_converters.h"
#include "server/wire/surface_points.h"

namespace latticed {
namespace {

void Append(Vec3d v, google::protobuf::RepeatedField<double>& flat) {
  for (int axis = 0; axis < 3; ++axis) flat.Add(v[axis]);
}

DeformedPoint Evaluate(const SceneState& state, const RestPoint& rest,
                       v1::EvaluatePointsResponse* response) {
  DeformedPoint point = EvaluateWorld(*state.plan, *state.control_points, rest.position);
  if (state.plan->is_weighted()) {  // a point of the world has the weight 1
    Weigh(rest.position, rest.weight, rest.weight_gradient, point.position, point.jacobian);
  }
  Append(point.position, *response->mutable_positions());
  for (const Vec3d column : point.jacobian) Append(column, *response->mutable_jacobians());
  return point;
}

absl::Status EvaluateSurface(const SceneState& state, const v1::SurfacePoints& points,
                             v1::EvaluatePointsResponse* response) {
  if (points.points_size() < 1 || points.points_size() > limits::kMaxEvaluatePoints) {
    return error::OutOfRange("surface_points.points", points.points_size(), 1,
                             limits::kMaxEvaluatePoints);
  }
  for (int i = 0; i < points.points_size(); ++i) {
    LATTICED_ASSIGN_OR_RETURN(
        const auto rest,
        RestPointFromProto(*state.plan->mesh, state.plan->mesh_weights, points.points(i),
                           fmt::format("surface_points.points[{}]", i)));
    const DeformedPoint deformed = Evaluate(state, rest, response);
    const Vec3d normal = ApplyCofactor(deformed.jacobian, rest.normal);
    const double length = Norm(normal);
    const double condition = CofactorNorm(deformed.jacobian) * Norm(rest.normal);
    const bool defined = length > 0 && condition <= kMaxNormalCondition * length;
    Append(defined ? normal / length : Vec3d{}, *response->mutable_normals());
  }
  return absl::OkStatus();
}

absl::Status EvaluateWorldPoints(const SceneState& state, const v1::WorldPoints& message,
                                 v1::EvaluatePointsResponse* response) {
  LATTICED_ASSIGN_OR_RETURN(
      const auto points,
      PointsFromProto(message.positions(), limits::kMaxEvaluatePoints, "world_points.positions"));
  if (points.empty())
    return error::OutOfRange("world_points.positions", 0, 1, limits::kMaxEvaluatePoints);
  for (const Vec3d point : points) Evaluate(state, {.position = point}, response);
  return absl::OkStatus();
}

}  // namespace

absl::Status EvaluatePoints(const SceneState& state, const v1::EvaluatePointsRequest& request,
                            v1::EvaluatePointsResponse* response) {
  response->set_revision(state.revision);
  switch (request.points_case()) {
    case v1::EvaluatePointsRequest::kSurfacePoints:
      return EvaluateSurface(state, request.surface_points(), response);
    case v1::EvaluatePointsRequest::kWorldPoints:
      return EvaluateWorldPoints(state, request.world_points(), response);
    case v1::EvaluatePointsRequest::POINTS_NOT_SET:
      break;
  }
  if (HoldsUnknown(request)) return error::Unsupported("points", "this kind of points");
  return error::InvalidField("points", "surface_points or world_points must be set");
}

}  // namespace latticed
