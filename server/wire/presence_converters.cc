// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/presence_converters.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/wire/converters.h"

namespace latticed {
namespace {

// Counts code points. The text is valid UTF-8, as every string of a parsed message is.
size_t CharactersOf(const std::string& text) {
  return static_cast<size_t>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }));
}

absl::StatusOr<double> ExtentOf(const v1::Camera& message) {
  const auto checked = [](const char* field, double got, double lowest,
                          double highest) -> absl::StatusOr<double> {
    if (!std::isfinite(got)) return error::NotFinite(field);
    LATTICED_RETURN_IF_ERROR(error::CheckRange(field, got, lowest, highest));
    return got;
  };
  switch (message.projection_case()) {
    case v1::Camera::kFovY:
      return checked("presence.camera.fov_y", message.fov_y(), limits::kMinCameraFovDegrees,
                     limits::kMaxCameraFovDegrees);
    case v1::Camera::kHeight:
      return checked("presence.camera.height", message.height(), limits::kMinCameraHeight,
                     limits::kMaxCoordinate);
    case v1::Camera::PROJECTION_NOT_SET:
      break;
  }
  return error::InvalidField("presence.camera", "needs fov_y or height");
}

absl::StatusOr<Camera> CameraFromProto(const v1::Camera& message) {
  Camera camera;
  LATTICED_ASSIGN_OR_RETURN(camera.position,
                            BoundedFromProto(message.position(), "presence.camera.position"));
  LATTICED_ASSIGN_OR_RETURN(camera.target,
                            BoundedFromProto(message.target(), "presence.camera.target"));
  if (camera.target == camera.position) {
    return error::InvalidField("presence.camera.target", "must not be the position");
  }
  LATTICED_ASSIGN_OR_RETURN(camera.up, BoundedFromProto(message.up(), "presence.camera.up"));
  if (camera.up == Vec3d{}) return error::InvalidField("presence.camera.up", "must not be zero");
  LATTICED_ASSIGN_OR_RETURN(camera.extent, ExtentOf(message));
  if (message.has_height()) camera.projection = Camera::Projection::kOrthographic;
  return camera;
}

v1::Camera CameraToProto(const Camera& camera) {
  v1::Camera message;
  *message.mutable_position() = ToProto(camera.position);
  *message.mutable_target() = ToProto(camera.target);
  *message.mutable_up() = ToProto(camera.up);
  if (camera.projection == Camera::Projection::kPerspective) {
    message.set_fov_y(camera.extent);
  } else {
    message.set_height(camera.extent);
  }
  return message;
}

}  // namespace

absl::StatusOr<Presence> FromProto(const v1::Presence& message) {
  if (const size_t characters = CharactersOf(message.name());
      characters > limits::kMaxPresenceName) {
    return error::InvalidField("presence.name",
                               fmt::format("has {} characters, at most {} are allowed", characters,
                                           limits::kMaxPresenceName),
                               "OUT_OF_RANGE");
  }
  if (message.colour() > limits::kMaxPresenceColour) {
    return error::OutOfRange("presence.colour", message.colour(), 0, limits::kMaxPresenceColour);
  }
  const auto& indices = message.selected_indices();
  if (static_cast<size_t>(indices.size()) > limits::kMaxPresenceIndices) {
    return error::OutOfRange("presence.selected_indices", indices.size(), 0,
                             static_cast<double>(limits::kMaxPresenceIndices));
  }
  for (int i = 0; i < indices.size(); ++i) {
    if (indices[i] < static_cast<uint32_t>(limits::kMaxControlPoints)) continue;
    return error::OutOfRange(fmt::format("presence.selected_indices[{}]", i), indices[i], 0,
                             limits::kMaxControlPoints - 1);
  }
  if (message.lattice() >= static_cast<uint32_t>(limits::kMaxLattices)) {
    return error::OutOfRange("presence.lattice", message.lattice(), 0, limits::kMaxLattices - 1);
  }
  if (message.following().size() > limits::kMaxEditorIdBytes) {
    return error::InvalidField("presence.following",
                               fmt::format("at most {} bytes", limits::kMaxEditorIdBytes));
  }
  if (message.left()) return error::InvalidField("presence.left", "is set only by the server");
  std::optional<Camera> camera;
  if (message.has_camera()) {
    LATTICED_ASSIGN_OR_RETURN(camera, CameraFromProto(message.camera()));
  }
  return Presence{.editor_id = message.editor_id(),
                  .name = message.name(),
                  .colour = message.colour(),
                  .selected = {indices.begin(), indices.end()},
                  .lattice = message.lattice(),
                  .camera = camera,
                  .following = message.following()};
}

v1::Presence ToProto(const Presence& presence) {
  v1::Presence message;
  message.set_editor_id(presence.editor_id);
  message.set_name(presence.name);
  message.set_colour(presence.colour);
  message.mutable_selected_indices()->Add(presence.selected.begin(), presence.selected.end());
  message.set_lattice(presence.lattice);
  if (presence.camera.has_value()) *message.mutable_camera() = CameraToProto(*presence.camera);
  message.set_following(presence.following);
  message.set_left(presence.left);
  return message;
}

}  // namespace latticed
