// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/shader_verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

// Tessellators compute in fixed point, often with 16 bits. This is the limit for the sum of three
// coordinates, and for the sum of a patch's areas.
constexpr double kCoordinateError = 1e-4;

double Aspect(const DeformPlan& plan, size_t patch) {
  std::array<Vec3d, 3> corner;
  for (size_t c = 0; c < 3; ++c) {
    corner[c] = plan.vertices[plan.patches[patch].vertex[c]].world;
  }
  double longest = 0;
  for (size_t c = 0; c < 3; ++c) {
    longest = std::max(longest, Norm(corner[(c + 1) % 3] - corner[c]));
  }
  return longest * longest / Norm(Cross(corner[1] - corner[0], corner[2] - corner[0]));
}

// Twice the area of a triangle in (b1, b2). The areas of a patch add up to 1.
double Area(const ShaderVertex* v) {
  const Vec3d a = ToDouble(v[0].coordinate), b = ToDouble(v[1].coordinate);
  const Vec3d c = ToDouble(v[2].coordinate);
  return std::abs((b.y - a.y) * (c.z - a.z) - (c.y - a.y) * (b.z - a.z));
}

// Checks that vertices are finite, coordinates are in the triangle, and triangles cover the patch once.
absl::Status CheckPattern(size_t patch, std::span<const ShaderVertex> vertices) {
  double area = 0;
  for (size_t i = 0; i + 2 < vertices.size(); i += 3) area += Area(&vertices[i]);
  for (const ShaderVertex& v : vertices) {
    const Vec3d b = ToDouble(v.coordinate);
    if (!IsFinite(ToDouble(v.position)) || !IsFinite(ToDouble(v.normal))) {
      return absl::InternalError(fmt::format("patch {}: a vertex is not finite", patch));
    }
    if (v.patch != static_cast<int64_t>(patch) || !(std::min({b.x, b.y, b.z}) >= 0) ||
        !(std::abs(b.x + b.y + b.z - 1) <= kCoordinateError)) {
      return absl::InternalError(fmt::format("patch {}: a vertex of patch {} at ({}, {}, {})",
                                             patch, v.patch, b.x, b.y, b.z));
    }
  }
  if (!(std::abs(area - 1) <= kCoordinateError)) {
    return absl::InternalError(fmt::format("patch {}: triangles of {} patches", patch, area));
  }
  return absl::OkStatus();
}

size_t DistinctPoints(std::span<const ShaderVertex> vertices) {
  std::set<std::array<float, 2>> points;
  for (const ShaderVertex& v : vertices) points.insert({v.coordinate.y, v.coordinate.z});
  return points.size();
}

}  // namespace

absl::StatusOr<ComparatorPrecision> CompareShaders(const DeformPlan& plan,
                                                   std::span<const Vec3d> control_points,
                                                   size_t first, size_t count,
                                                   std::span<const ShaderVertex> vertices) {
  if (count == 0 || vertices.empty() || vertices.size() % (3 * count) != 0) {
    return absl::InternalError(fmt::format("{} vertices of {} patches", vertices.size(), count));
  }
  const size_t per_patch = vertices.size() / count;
  const DirectFfd direct(plan, control_points);
  ComparatorPrecision result;
  result.distinct_points = DistinctPoints(vertices.first(per_patch));
  for (size_t patch = first; patch < first + count; ++patch) {
    const auto of_patch = vertices.subspan((patch - first) * per_patch, per_patch);
    LATTICED_RETURN_IF_ERROR(CheckPattern(patch, of_patch));
    const double aspect = Aspect(plan, patch);
    for (const ShaderVertex& v : of_patch) {
      const double b1 = double{v.coordinate.y}, b2 = double{v.coordinate.z};
      result.Add(direct.Evaluate(patch, {1 - b1 - b2, b1, b2}, DirectFfd::Normal::kFacet),
                 plan.local_origin + ToDouble(v.position), ToDouble(v.normal), aspect);
    }
  }
  return result;
}

}  // namespace latticed::bench
