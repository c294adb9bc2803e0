// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exact_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/status_macros.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

constexpr double kMeshPadding = 0.05;
constexpr int kProbeResolution = 8;  // 46,000 triangles: enough to estimate how many the planes cut

using SharedMesh = std::shared_ptr<const PolygonMesh>;
using SharedPlan = std::shared_ptr<const DeformPlan>;

// The knot at `resolution`, which may exceed the sample's largest.
absl::StatusOr<SharedMesh> Knot(int resolution) {
  int subdivisions = 0;
  while ((resolution >> subdivisions) > kMaxSampleResolution) ++subdivisions;
  const int rounding = (1 << subdivisions) - 1;
  LATTICED_ASSIGN_OR_RETURN(auto mesh,
                            MakeSampleMesh("knot", std::min((resolution + rounding) >> subdivisions,
                                                            kMaxSampleResolution)));
  mesh = Fans(mesh);
  for (int i = 0; i < subdivisions; ++i) mesh = Subdivide(mesh);
  return std::make_shared<const PolygonMesh>(std::move(mesh));
}

absl::StatusOr<SharedPlan> PlanOf(SharedMesh mesh, std::array<int, 3> degree) {
  std::array<int, 3> size{};
  for (size_t axis = 0; axis < 3; ++axis) size[axis] = kBoxesPerAxis + degree[axis];
  LATTICED_ASSIGN_OR_RETURN(const auto lattice,
                            FitLattice(mesh->ComputeBounds(), size, degree, kMeshPadding));
  return MakePlan(std::move(mesh), lattice.structure);
}

// patches = by_area r² + by_length r: the triangles, plus those that the planes add along their curves.
absl::StatusOr<int> ResolutionFor(size_t patches, std::array<int, 3> degree) {
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, Knot(kProbeResolution));
  LATTICED_ASSIGN_OR_RETURN(const auto probe, PlanOf(mesh, degree));
  const double r = kProbeResolution, triangles = static_cast<double>(mesh->face_count());
  const double by_area = triangles / (r * r);
  const double by_length = (static_cast<double>(probe->patches.size()) - triangles) / r;
  const double wanted = static_cast<double>(patches);
  const double half = by_length / (2 * by_area);
  return std::max(kMinSampleResolution,
                  static_cast<int>(std::ceil(std::sqrt(wanted / by_area + half * half) - half)));
}

}  // namespace

PolygonMesh Fans(const PolygonMesh& polygons) {
  PolygonMesh result;
  result.positions = polygons.positions;
  for (size_t f = 0; f < polygons.face_count(); ++f) {
    const uint32_t* v = polygons.corner_vertices.data() + polygons.face_offsets[f];
    const uint32_t corners = polygons.face_offsets[f + 1] - polygons.face_offsets[f];
    for (uint32_t c = 1; c + 1 < corners; ++c) {
      result.corner_vertices.insert(result.corner_vertices.end(), {v[0], v[c], v[c + 1]});
      result.face_offsets.push_back(static_cast<uint32_t>(result.corner_vertices.size()));
    }
  }
  return result;
}

PolygonMesh Subdivide(const PolygonMesh& triangles) {
  PolygonMesh result;
  result.positions = triangles.positions;
  absl::flat_hash_map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  middles.reserve(2 * triangles.face_count());
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [it, fresh] = middles.try_emplace(std::pair<uint32_t, uint32_t>(std::minmax(a, b)),
                                                 static_cast<uint32_t>(result.positions.size()));
    if (fresh) result.positions.push_back((result.positions[a] + result.positions[b]) / 2.0);
    return it->second;
  };
  const auto face = [&](uint32_t a, uint32_t b, uint32_t c) {
    result.corner_vertices.insert(result.corner_vertices.end(), {a, b, c});
    result.face_offsets.push_back(static_cast<uint32_t>(result.corner_vertices.size()));
  };
  for (size_t f = 0; f < triangles.face_count(); ++f) {
    const uint32_t* v = triangles.corner_vertices.data() + triangles.face_offsets[f];
    const uint32_t ab = middle(v[0], v[1]), bc = middle(v[1], v[2]), ca = middle(v[2], v[0]);
    face(v[0], ab, ca);
    face(ab, v[1], bc);
    face(ca, bc, v[2]);
    face(ab, bc, ca);
  }
  return result;
}

absl::StatusOr<PolygonMesh> Trim(const DeformPlan& plan, size_t patches) {
  const PolygonMesh& mesh = *plan.mesh;
  std::vector<size_t> patches_of(mesh.face_count(), 0);
  for (const PatchSource& source : plan.sources) ++patches_of[source.face];
  if (plan.patches.size() < patches) return absl::InternalError("too few patches to trim");
  size_t excess = plan.patches.size() - patches;
  PolygonMesh result;
  result.positions = mesh.positions;
  std::vector<bool> kept(mesh.face_count(), true);
  for (size_t f = mesh.face_count(); f-- > 0 && excess > 0;) {
    if (patches_of[f] > excess) continue;
    kept[f] = false;
    excess -= patches_of[f];
  }
  if (excess > 0) return absl::InternalError("no set of faces has exactly the excess patches");
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    if (!kept[f]) continue;
    result.corner_vertices.insert(result.corner_vertices.end(),
                                  mesh.corner_vertices.begin() + mesh.face_offsets[f],
                                  mesh.corner_vertices.begin() + mesh.face_offsets[f + 1]);
    result.face_offsets.push_back(static_cast<uint32_t>(result.corner_vertices.size()));
  }
  return result;
}

absl::StatusOr<SharedPlan> MakeRoughPlan(size_t patches, std::array<int, 3> degree) {
  LATTICED_ASSIGN_OR_RETURN(const auto resolution, ResolutionFor(patches, degree));
  for (int r = resolution;; ++r) {
    LATTICED_ASSIGN_OR_RETURN(auto mesh, Knot(r));
    auto plan = PlanOf(std::move(mesh), degree);
    if (!plan.ok() || (*plan)->patches.size() >= patches) return plan;
  }
}

absl::StatusOr<SharedPlan> MakeExactPlan(size_t patches, std::array<int, 3> degree) {
  LATTICED_ASSIGN_OR_RETURN(const auto rough, MakeRoughPlan(patches, degree));
  LATTICED_ASSIGN_OR_RETURN(auto trimmed, Trim(*rough, patches));
  auto plan = MakePlan(std::make_shared<const PolygonMesh>(std::move(trimmed)), rough->structure);
  if (!plan.ok() || (*plan)->patches.size() == patches) return plan;
  return absl::InternalError(
      fmt::format("the trimmed mesh has {} patches, wanted {}", (*plan)->patches.size(), patches));
}

}  // namespace latticed::bench
