// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/session/scene_tolerance.h"

#include "core/base/bounds.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

// Of the corners of all patches: with 1 segment these are all points of a view.
absl::StatusOr<double> DeformedDiagonal(Client& client, const std::string& scene) {
  v1::GetUpdateRequest request;
  request.set_scene(scene);
  request.mutable_view()->set_segments(1);
  request.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  LATTICED_ASSIGN_OR_RETURN(const auto surface, client.GetUpdate(request));
  LATTICED_ASSIGN_OR_RETURN(const auto points, surface.Decode());
  Bounds bounds;
  for (const Vec3d position : points.positions) bounds.Extend(position);
  return bounds.diagonal();
}

}  // namespace

absl::Status SetTolerance(Client& client, const std::string& scene, const Tolerance& tolerance,
                          v1::ViewOptions* view) {
  if (tolerance.number == 0) return absl::OkStatus();
  double meters_per_unit = 0;
  if (tolerance.unit == Tolerance::Unit::kMetres) {
    LATTICED_ASSIGN_OR_RETURN(const auto described, client.GetScene(scene));
    meters_per_unit = described.units().meters_per_unit();
  }
  LATTICED_ASSIGN_OR_RETURN(const double distance, InWorldUnits(tolerance, meters_per_unit, [&] {
                              return DeformedDiagonal(client, scene);
                            }));
  view->set_tolerance(distance);
  return absl::OkStatus();
}

}  // namespace latticed::client
