// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// EvaluatePoints: the definition in double at points of the surface or of the rest world.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "server/converters.h"
#include "server/scene_converters.h"

namespace latticed {
namespace {

// Barycentrics that a client computed in double sum to 1 to much better than this.
constexpr double kBarycentricTolerance = 1e-9;

// A point of the rest surface, and the normal of the source triangle there (not normalised).
struct RestPoint {
  Vec3d position;
  Vec3d normal;
};

absl::Status CheckCorners(const PolygonMesh& mesh, const v1::SurfacePoint& point,
                          const std::string& field) {
  if (point.face() >= mesh.face_count()) {
    return error::OutOfRange(field + ".face", point.face(), 0,
                             static_cast<double>(mesh.face_count()) - 1);
  }
  if (point.corners_size() != 3) {
    return error::InvalidField(field + ".corners",
                               fmt::format("got {}, 3 are needed", point.corners_size()));
  }
  const uint32_t first = mesh.face_offsets[point.face()];
  const uint32_t last = mesh.face_offsets[point.face() + 1] - 1;
  for (int c = 0; c < 3; ++c) {
    const uint32_t corner = point.corners(c);
    const std::string path = fmt::format("{}.corners[{}]", field, c);
    if (corner < first || corner > last) return error::OutOfRange(path, corner, first, last);
    if (std::count(point.corners().begin(), point.corners().end(), corner) > 1) {
      return error::InvalidField(path, fmt::format("corner {} is named twice", corner));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckBarycentrics(const v1::SurfacePoint& point, const std::string& field) {
  if (point.barycentrics_size() != 3) {
    return error::InvalidField(field + ".barycentrics",
                               fmt::format("got {}, 3 are needed", point.barycentrics_size()));
  }
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const double b = point.barycentrics(c);
    const std::string path = fmt::format("{}.barycentrics[{}]", field, c);
    if (!std::isfinite(b)) return error::NotFinite(path);
    if (b < 0 || b > 1) return error::OutOfRange(path, b, 0, 1);
    sum += b;
  }
  if (std::abs(sum - 1) > kBarycentricTolerance) {
    return error::InvalidField(field + ".barycentrics",
                               fmt::format("their sum is {}, it must be 1", sum));
  }
  return absl::OkStatus();
}

absl::StatusOr<RestPoint> ReadSurfacePoint(const PolygonMesh& mesh, const v1::SurfacePoint& point,
                                           const std::string& field) {
  if (auto s = CheckCorners(mesh, point, field); !s.ok()) return s;
  if (auto s = CheckBarycentrics(point, field); !s.ok()) return s;
  const auto world = [&mesh](uint32_t corner) {
    return mesh.positions[mesh.corner_vertices[corner]];
  };
  RestPoint rest;
  for (int c = 0; c < 3; ++c) rest.position += point.barycentrics(c) * world(point.corners(c));
  // In the order of the face the triangle has the face's winding, whatever order the client chose.
  std::array<uint32_t, 3> corners{point.corners(0), point.corners(1), point.corners(2)};
  std::ranges::sort(corners);
  rest.normal = Cross(world(corners[1]) - world(corners[0]), world(corners[2]) - world(corners[0]));
  return rest;
}

void Append(Vec3d v, google::protobuf::RepeatedField<double>& flat) {
  for (int axis = 0; axis < 3; ++axis) flat.Add(v[axis]);
}

DeformedPoint Evaluate(const SceneState& state, Vec3d world, v1::EvaluatePointsResponse* response) {
  const DeformedPoint point = EvaluateWorld(state.structure(), *state.control_points, world);
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
    const auto rest = ReadSurfacePoint(*state.plan->mesh, points.points(i),
                                       fmt::format("surface_points.points[{}]", i));
    if (!rest.ok()) return rest.status();
    const DeformedPoint deformed = Evaluate(state, rest->position, response);
    const Vec3d normal = ApplyCofactor(deformed.jacobian, rest->normal);
    const double length = Norm(normal);
    const double condition = CofactorNorm(deformed.jacobian) * Norm(rest->normal);
    const bool defined = length > 0 && condition <= kMaxNormalCondition * length;
    Append(defined ? normal / length : Vec3d{}, *response->mutable_normals());
  }
  return absl::OkStatus();
}

absl::Status EvaluateWorldPoints(const SceneState& state, const v1::WorldPoints& message,
                                 v1::EvaluatePointsResponse* response) {
  const auto points =
      PointsFromProto(message.positions(), limits::kMaxEvaluatePoints, "world_points.positions");
  if (!points.ok()) return points.status();
  if (points->empty())
    return error::OutOfRange("world_points.positions", 0, 1, limits::kMaxEvaluatePoints);
  for (const Vec3d point : *points) Evaluate(state, point, response);
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
