// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Barycentrics that a client computed in double precision have a sum much closer to 1 than this.
constexpr double kBarycentricTolerance = 1e-9;

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

}  // namespace

absl::StatusOr<RestPoint> RestPointFromProto(const PolygonMesh& mesh, const VertexWeights& weights,
                                             const v1::SurfacePoint& point,
                                             const std::string& field) {
  LATTICED_RETURN_IF_ERROR(CheckCorners(mesh, point, field));
  LATTICED_RETURN_IF_ERROR(CheckBarycentrics(point, field));
  const auto world = [&mesh](uint32_t corner) {
    return mesh.positions[mesh.corner_vertices[corner]];
  };
  RestPoint rest;
  for (int c = 0; c < 3; ++c) rest.position += point.barycentrics(c) * world(point.corners(c));
  // Sorted corners give the triangle the face's winding, whatever order the client chose.
  std::array<uint32_t, 3> corners{point.corners(0), point.corners(1), point.corners(2)};
  std::ranges::sort(corners);
  rest.normal = Cross(world(corners[1]) - world(corners[0]), world(corners[2]) - world(corners[0]));
  if (weights == nullptr) return rest;
  std::array<Vec3d, 3> triangle;
  std::array<double, 3> of_corner;
  rest.weight = 0;
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<size_t>(c);
    triangle[k] = world(point.corners(c));
    of_corner[k] = (*weights)[mesh.corner_vertices[point.corners(c)]];
    rest.weight += point.barycentrics(c) * of_corner[k];
  }
  rest.weight_gradient = WeightGradient(triangle, of_corner);
  return rest;
}

}  // namespace latticed
