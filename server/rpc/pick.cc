// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pick: the first point of a state's exact surface on a ray, as a point of the source mesh.
#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/pick/surface_pick.h"
#include "server/wire/converters.h"
#include "server/wire/scene_converters.h"

namespace latticed {
namespace {

absl::StatusOr<Ray> RayFromProto(const v1::PickRequest& request) {
  if (!request.has_ray()) return error::InvalidField("ray", "is required");
  LATTICED_ASSIGN_OR_RETURN(const auto origin,
                            BoundedFromProto(request.ray().origin(), "ray.origin"));
  LATTICED_ASSIGN_OR_RETURN(const auto direction,
                            FromProto(request.ray().direction(), "ray.direction"));
  if (direction == Vec3d{}) return error::InvalidField("ray.direction", "must not be zero");
  return Ray{origin, direction};
}

// Barycentrics in the source triangle, as EvaluatePoints and drag_points take them: each from 0 to 1, with a sum
// of 1 up to rounding.
std::array<double, 3> InSourceTriangle(const PatchSource& source,
                                       const std::array<double, 3>& in_patch) {
  std::array<double, 3> b{};
  double sum = 0;
  for (size_t k = 0; k < 3; ++k) {
    for (size_t c = 0; c < 3; ++c) b[k] += in_patch[c] * source.barycentrics[c][k];
    b[k] = std::clamp(b[k], 0.0, 1.0);
    sum += b[k];
  }
  for (double& weight : b) weight /= sum;
  return b;
}

}  // namespace

absl::Status Pick(const SceneState& state, const v1::PickRequest& request, StopCheck stop,
                  v1::SurfacePoint* response) {
  LATTICED_ASSIGN_OR_RETURN(const auto ray, RayFromProto(request));
  const DeformPlan& plan = *state.plan;
  LATTICED_ASSIGN_OR_RETURN(const auto hit,
                            PickSurface(plan, *state.patch_tree, *state.control_points, ray, stop));
  if (!hit.has_value()) return error::NothingHit();

  const auto& [patch, barycentrics] = *hit;
  const PatchSource& source = plan.sources[patch];
  response->set_face(source.face);
  for (const uint32_t corner : source.corners) response->add_corners(corner);
  for (const double b : InSourceTriangle(source, barycentrics)) response->add_barycentrics(b);
  const DirectFfd ffd(plan, *state.control_points);
  const auto point = ffd.Evaluate(patch, barycentrics, DirectFfd::Normal::kFacet);
  *response->mutable_position() = ToProto(point.position);
  if (!point.substituted) *response->mutable_normal() = ToProto(point.normal);
  return absl::OkStatus();
}

}  // namespace latticed
