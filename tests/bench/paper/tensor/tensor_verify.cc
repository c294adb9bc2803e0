// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/tensor/tensor_verify.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

double Aspect(const ParameterRectangle& rectangle) {
  const auto [shorter, longer] = std::minmax({Norm(rectangle.along), Norm(rectangle.across)});
  return longer / shorter;
}

struct PatchPoint {
  uint32_t patch = 0;
  std::array<double, 3> barycentrics{};
};

// Finds the patch of the polygon that contains x, a point of the polygon's plane. If rounding puts
// x outside all patches, returns the nearest one, whose barycentrics still name the place.
PatchPoint FindInPatches(const DeformPlan& plan, const SubPolygon& polygon, Vec3d normal, Vec3d x) {
  PatchPoint best;
  double deepest = -std::numeric_limits<double>::infinity();
  for (const uint32_t patch : polygon.patches) {
    std::array<Vec3d, 3> to_corner;
    for (size_t c = 0; c < 3; ++c) {
      to_corner[c] = plan.vertices[plan.patches[patch].vertex[c]].world - x;
    }
    std::array<double, 3> area{};
    for (size_t c = 0; c < 3; ++c) {
      area[c] = Dot(Cross(to_corner[(c + 1) % 3], to_corner[(c + 2) % 3]), normal);
    }
    const double whole = area[0] + area[1] + area[2];
    const std::array<double, 3> b{area[0] / whole, area[1] / whole, area[2] / whole};
    const double depth = std::min({b[0], b[1], b[2]});
    if (!(whole > 0 && depth > deepest)) continue;
    deepest = depth;
    best = {patch, b};
  }
  return best;
}

absl::Status AddSurface(const DeformPlan& plan, const DirectFfd& direct,
                        const TensorSurfaces& surfaces, size_t surface,
                        std::span<const TensorVertex> vertices, ComparatorPrecision& precision) {
  const SubPolygon& polygon = surfaces.polygons[surface];
  const Vec3d normal = direct.RestFacetNormal(polygon.patches.front());
  const ParameterRectangle rectangle = RectangleOf(plan, polygon, normal);
  const double aspect = Aspect(rectangle);
  const size_t end = surfaces.surfaces[surface + 1].first_point;
  for (size_t i = surfaces.surfaces[surface].first_point; i < end; ++i) {
    const TensorPoint& point = surfaces.points[i];
    const double s = double{point.s}, t = double{surfaces.lines[point.line].t};
    const Vec3d x = rectangle.corner + s * rectangle.along + t * rectangle.across;
    const PatchPoint place = FindInPatches(plan, polygon, normal, x);
    const Vec3d position = plan.local_origin + ToDouble(vertices[i].position);
    const Vec3d got_normal = ToDouble(vertices[i].normal);
    if (!IsFinite(position) || !IsFinite(got_normal)) {
      return absl::InternalError(fmt::format("surface {}: a vertex is not finite", surface));
    }
    // No patch of a polygon without area can name the point's place.
    if (place.barycentrics == std::array<double, 3>{}) continue;
    precision.Add(direct.Evaluate(place.patch, place.barycentrics, DirectFfd::Normal::kFacet),
                  position, got_normal, aspect);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ComparatorPrecision> CompareTensor(const DeformPlan& plan,
                                                  std::span<const Vec3d> control_points,
                                                  const TensorSurfaces& surfaces,
                                                  std::span<const TensorVertex> vertices,
                                                  size_t stride) {
  if (vertices.size() != surfaces.points.size()) {
    return absl::InternalError(
        fmt::format("{} vertices of {} points", vertices.size(), surfaces.points.size()));
  }
  const DirectFfd direct(plan, control_points);
  ComparatorPrecision precision;
  for (size_t surface = 0; surface < surfaces.count(); surface += stride) {
    LATTICED_RETURN_IF_ERROR(AddSurface(plan, direct, surfaces, surface, vertices, precision));
  }
  return precision;
}

}  // namespace latticed::bench
