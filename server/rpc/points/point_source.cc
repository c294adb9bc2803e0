// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/points/point_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "server/wire/surface_points.h"
#include "server/wire/view_converters.h"

namespace latticed {
namespace {

using Source = v1::PointSetHeader;

// A point of the surface as it is sent.
struct SurfaceRecord {
  uint32_t face;
  uint32_t corners[3];
  double barycentrics[3];
};
static_assert(sizeof(SurfaceRecord) == 40);

absl::Status CheckCount(uint64_t points, std::string_view field) {
  if (points >= 1 && points <= limits::kMaxPointSetPoints) return absl::OkStatus();
  return error::OutOfRange(field, static_cast<double>(points), 1,
                           static_cast<double>(limits::kMaxPointSetPoints));
}

absl::StatusOr<ViewSpec> ViewOf(const Source& header, const Scene& scene) {
  LATTICED_ASSIGN_OR_RETURN(
      const WatchView view,
      WatchViewFromProto(header.view(), scene.config().default_view, "header.view"));
  const ViewSpec& spec = view.key.spec;
  if (!HasPositions(spec))
    return error::Unsupported("header.view.encoding", "a view without points");
  if (spec.tolerance > 0) {
    return error::Unsupported("header.view.tolerance",
                              "a tolerance, whose points change with edits,");
  }
  LATTICED_RETURN_IF_ERROR(Validate(spec));
  return spec;
}

RestNumbers ViewPoints(const SceneState& state, const ViewSpec& spec) {
  const DeformPlan& plan = *state.plan;
  const DirectFfd at_rest(plan, plan.identity_points);
  const auto& pattern = TessellationPattern::Get(spec.segments).points;
  const size_t count = plan.patches.size() * pattern.size();
  const bool with_normals = spec.normals != NormalMode::kNone;
  RestNumbers numbers{std::vector<double>(3 * count * (with_normals ? 2 : 1)), {}};
  if (plan.is_weighted()) numbers.weights.resize(count);
  const std::span<Vec3d> vectors = AsVectors(numbers.vectors);
  size_t next = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    std::array<Vec3d, 3> corner;
    for (size_t c = 0; c < 3; ++c) corner[c] = plan.vertices[plan.patches[p].vertex[c]].world;
    const Vec3d facet = at_rest.RestFacetNormal(p);
    std::array<double, 3> weight{};
    Vec3d gradient;
    if (plan.is_weighted()) {
      weight = plan.CornerWeights(p);
      gradient = plan.PatchWeightGradient(p);
    }
    for (const auto& number : pattern) {
      std::array<double, 3> b{};
      for (size_t c = 0; c < 3; ++c) b[c] = static_cast<double>(number[c]) / spec.segments;
      vectors[next] = b[0] * corner[0] + b[1] * corner[1] + b[2] * corner[2];
      if (plan.is_weighted()) {
        numbers.weights[next] = {b[0] * weight[0] + b[1] * weight[1] + b[2] * weight[2], gradient};
      }
      if (with_normals) {
        vectors[count + next] =
            spec.normals == NormalMode::kFacet ? facet : Unit(at_rest.RestSmoothNormal(p, b));
      }
      ++next;
    }
  }
  return numbers;
}

absl::StatusOr<RestNumbers> SurfacePoints(const DeformPlan& plan, const std::vector<double>& data) {
  const size_t count = data.size() * sizeof(double) / sizeof(SurfaceRecord);
  RestNumbers numbers{std::vector<double>(6 * count), {}};
  if (plan.is_weighted()) numbers.weights.reserve(count);
  const std::span<Vec3d> vectors = AsVectors(numbers.vectors);
  v1::SurfacePoint point;
  for (size_t i = 0; i < count; ++i) {
    SurfaceRecord record;
    std::memcpy(&record, reinterpret_cast<const char*>(data.data()) + i * sizeof(record),
                sizeof(record));
    point.Clear();
    point.set_face(record.face);
    point.mutable_corners()->Add(std::begin(record.corners), std::end(record.corners));
    point.mutable_barycentrics()->Add(std::begin(record.barycentrics),
                                      std::end(record.barycentrics));
    LATTICED_ASSIGN_OR_RETURN(const RestPoint rest,
                              RestPointFromProto(*plan.mesh, plan.mesh_weights, point,
                                                 fmt::format("data.points[{}]", i)));
    if (plan.is_weighted()) numbers.weights.push_back({rest.weight, rest.weight_gradient});
    vectors[i] = rest.position;
    vectors[count + i] = Unit(rest.normal);
  }
  return numbers;
}

}  // namespace

absl::Status CheckFinite(std::span<const Vec3d> vectors, std::string_view field) {
  const auto found = std::ranges::find_if_not(vectors, [](Vec3d v) { return IsFinite(v); });
  if (found == vectors.end()) return absl::OkStatus();
  return error::NotFinite(fmt::format("{}[{}]", field, found - vectors.begin()));
}

absl::StatusOr<AnnouncedPoints> Announced(const Source& header, const Scene& scene,
                                          const SceneState& state) {
  // Weights are of the surface: points of the world follow the lattice.
  const bool weighted = state.plan->is_weighted();
  switch (header.source_case()) {
    case Source::kWorld: {
      const uint64_t points = header.world().points();
      const bool with_normals = header.world().with_normals();
      LATTICED_RETURN_IF_ERROR(CheckCount(points, "header.world.points"));
      return AnnouncedPoints{points, with_normals, false,
                             points * sizeof(Vec3d) * (with_normals ? 2 : 1)};
    }
    case Source::kSurface: {
      const uint64_t points = header.surface().points();
      LATTICED_RETURN_IF_ERROR(CheckCount(points, "header.surface.points"));
      return AnnouncedPoints{points, true, weighted, points * sizeof(SurfaceRecord)};
    }
    case Source::kView: {
      LATTICED_ASSIGN_OR_RETURN(const ViewSpec spec, ViewOf(header, scene));
      const uint64_t points =
          state.plan->patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments));
      LATTICED_RETURN_IF_ERROR(CheckCount(points, "header.view.segments"));
      return AnnouncedPoints{points, spec.normals != NormalMode::kNone, weighted, 0};
    }
    case Source::SOURCE_NOT_SET:
      break;
  }
  if (HoldsUnknown(header)) return error::Unsupported("header", "this kind of points");
  return error::InvalidField("header", "one of world, surface and view must be set");
}

absl::StatusOr<RestNumbers> RestPoints(const Source& header, const Scene& scene,
                                       const SceneState& state, std::vector<double> data) {
  if (header.has_view()) {
    LATTICED_ASSIGN_OR_RETURN(const ViewSpec spec, ViewOf(header, scene));
    return ViewPoints(state, spec);
  }
  if (header.has_surface()) return SurfacePoints(*state.plan, data);
  const std::span<Vec3d> vectors = AsVectors(data);
  const size_t count = header.world().points();
  LATTICED_RETURN_IF_ERROR(CheckFinite(vectors.first(count), "data.positions"));
  LATTICED_RETURN_IF_ERROR(CheckFinite(vectors.subspan(count), "data.normals"));
  for (const Vec3d& p : vectors.first(count)) {
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    LATTICED_RETURN_IF_ERROR(error::CheckRange("data.positions", largest, -limits::kMaxCoordinate,
                                               limits::kMaxCoordinate));
  }
  for (Vec3d& normal : vectors.subspan(count)) normal = Unit(normal);
  return RestNumbers{std::move(data), {}};
}

}  // namespace latticed
