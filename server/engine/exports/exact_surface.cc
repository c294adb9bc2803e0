// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/exact_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/backend.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/mesh/short_edges.h"
#include "core/mesh/vertex_values.h"
#include "server/engine/exports/surface_patterns.h"

namespace latticed {
namespace {

// The UVs of a patch's corners, interpolated in its source triangle. A missing UV counts as 0.
std::array<Vec2f, 3> CornerUvs(const PolygonMesh& mesh, const PatchSource& source) {
  std::array<Vec2f, 3> result;
  for (size_t c = 0; c < 3; ++c) {
    double u = 0, v = 0;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t index = mesh.corner_uvs[source.corners[k]];
      if (index == PolygonMesh::kNoAttribute) continue;
      u += source.barycentrics[c][k] * double{mesh.uvs[index].x};
      v += source.barycentrics[c][k] * double{mesh.uvs[index].y};
    }
    result[c] = {static_cast<float>(u), static_cast<float>(v)};
  }
  return result;
}

Vec2f UvAt(const std::array<Vec2f, 3>& corners, const std::array<uint16_t, 3>& point,
           double denominator) {
  double u = 0, v = 0;
  for (size_t c = 0; c < 3; ++c) {
    u += point[c] / denominator * double{corners[c].x};
    v += point[c] / denominator * double{corners[c].y};
  }
  return {static_cast<float>(u), static_cast<float>(v)};
}

// Takes patches one after the other.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const SceneState& state, const ViewSpec& spec, Welding welding,
                 SurfacePatterns patterns)
      : plan_(*state.plan),
        patterns_(std::move(patterns)),
        points_(plan_, *state.control_points, patterns_, welding),
        has_normals_(spec.normals != NormalMode::kNone),
        has_uvs_(plan_.mesh->has_uvs()),
        normals_(has_normals_ ? points_.count() : 0, has_normals_ ? patterns_.PointCount() : 0),
        uvs_(has_uvs_ ? points_.count() : 0, has_uvs_ ? patterns_.PointCount() : 0) {
    const uint64_t triangles = patterns_.TriangleCount();
    mesh_.positions.resize(points_.count());
    mesh_.corner_vertices.reserve(3 * triangles);
    if (has_normals_) mesh_.corner_normals.reserve(3 * triangles);
    if (has_uvs_) mesh_.corner_uvs.reserve(3 * triangles);
    mesh_.group_names = plan_.mesh->group_names;
    if (!plan_.mesh->face_groups.empty()) mesh_.face_groups.reserve(triangles);
  }

  // `bytes`: float32 x y z [nx ny nz] of the patch's points, relative to the plan's local origin. Returns the rest.
  std::span<const uint8_t> AddPatch(size_t patch, std::span<const uint8_t> bytes) {
    const AdaptivePattern& pattern = patterns_.Of(patch);
    const std::vector<uint32_t> vertices = points_.OfPatch(patch);
    std::vector<uint32_t> normals(has_normals_ ? vertices.size() : 0);
    std::vector<Vec3d> positions;
    positions.reserve(vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
      positions.push_back(ToDouble(TakeVector(&bytes)));
      mesh_.positions[vertices[i]] = plan_.local_origin + positions.back();
      if (has_normals_) normals[i] = normals_.Add(vertices[i], TakeVector(&bytes));
    }
    NoteEdges(pattern, positions);
    AddCorners(pattern, vertices, &mesh_.corner_vertices);
    if (has_normals_) AddCorners(pattern, normals, &mesh_.corner_normals);
    if (has_uvs_) AddCorners(pattern, UvsOf(patch, vertices), &mesh_.corner_uvs);
    if (!plan_.mesh->face_groups.empty()) {
      mesh_.face_groups.insert(mesh_.face_groups.end(), pattern.triangles.size(),
                               plan_.mesh->face_groups[plan_.sources[patch].face]);
    }
    return bytes;
  }

  PolygonMesh Finish() && {
    const size_t triangles = mesh_.corner_count() / 3;
    mesh_.face_offsets.resize(triangles + 1);
    for (size_t t = 0; t <= triangles; ++t) mesh_.face_offsets[t] = static_cast<uint32_t>(3 * t);
    mesh_.normals = std::move(normals_).Take();
    mesh_.uvs = std::move(uvs_).Take();
    if (std::sqrt(least_square_) <= ShortEdgeLength(bounds_)) CollapseShortEdges(mesh_);
    return std::move(mesh_);
  }

 private:
  static Vec3f TakeVector(std::span<const uint8_t>* bytes) {
    Vec3f v;
    std::memcpy(&v, bytes->data(), sizeof(v));
    *bytes = bytes->subspan(sizeof(v));
    return v;
  }

  // Slivers are rare, and an edge is looked up fastest while its patch is at hand.
  void NoteEdges(const AdaptivePattern& pattern, const std::vector<Vec3d>& positions) {
    for (const Vec3d p : positions) bounds_.Extend(p);
    for (const auto& [a, b, c] : pattern.triangles) {
      const Vec3d u = positions[b] - positions[a], v = positions[c] - positions[b];
      const Vec3d w = positions[a] - positions[c];
      least_square_ = std::min({least_square_, Dot(u, u), Dot(v, v), Dot(w, w)});
    }
  }

  static void AddCorners(const AdaptivePattern& pattern, const std::vector<uint32_t>& of_points,
                         std::vector<uint32_t>* corners) {
    for (const auto& triangle : pattern.triangles) {
      for (const uint16_t point : triangle) corners->push_back(of_points[point]);
    }
  }

  std::vector<uint32_t> UvsOf(size_t patch, const std::vector<uint32_t>& vertices) {
    const std::array<Vec2f, 3> corners = CornerUvs(*plan_.mesh, plan_.sources[patch]);
    const AdaptivePattern& pattern = patterns_.Of(patch);
    std::vector<uint32_t> uvs;
    uvs.reserve(vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
      uvs.push_back(uvs_.Add(vertices[i], UvAt(corners, pattern.points[i], pattern.denominator)));
    }
    return uvs;
  }

  const DeformPlan& plan_;
  const SurfacePatterns patterns_;
  const WeldedPoints points_;
  const bool has_normals_, has_uvs_;
  VertexValues<Vec3f> normals_;
  VertexValues<Vec2f> uvs_;
  Bounds bounds_;                                                  // about the plan's local origin
  double least_square_ = std::numeric_limits<double>::infinity();  // of the lengths of edges
  PolygonMesh mesh_;
};

uint64_t MostPoints(const DeformPlan& plan, const ViewSpec& spec) {
  return plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments));
}

// A patch of p points, r of them on its rim, has 2 p - r - 2 triangles.
uint64_t MostTriangles(const DeformPlan& plan, const ViewSpec& spec) {
  if (spec.tolerance > 0) return 2 * MostPoints(plan, spec);
  return plan.patches.size() * static_cast<uint64_t>(TrianglesPerPatch(spec.segments));
}

SurfacePatterns PatternsOf(const DeformView& view, const DeformPlan& plan) {
  if (!(view.spec().tolerance > 0)) return {plan, view.spec().segments};
  const PatternCodes patterns = view.Patterns();
  return SurfacePatterns({patterns.codes.begin(), patterns.codes.end()});
}

// OBJ names a group wherever the next triangle has another.
void AddGroups(const DeformPlan& plan, WrittenSizes* sizes) {
  const PolygonMesh& mesh = *plan.mesh;
  if (mesh.face_groups.empty()) return;
  sizes->groups = mesh.group_names.size();
  for (const std::string& name : mesh.group_names) sizes->name_bytes += name.size();
  uint32_t last = PolygonMesh::kNoAttribute;
  for (const PatchSource& source : plan.sources) {
    const uint32_t group = mesh.face_groups[source.face];
    if (std::exchange(last, group) == group) continue;
    ++sizes->group_lines;
    sizes->group_line_bytes += mesh.group_names[group].size();
  }
}

}  // namespace

absl::StatusOr<PolygonMesh> ExactSurface(const RenderInput& input, const ViewSpec& asked,
                                         StopCheck stop, Welding welding, double* certified_error) {
  const SceneState& state = *input.state;
  const DeformPlan& plan = *state.plan;
  const ViewSpec spec{.segments = asked.segments,
                      .tolerance = asked.tolerance,
                      .normals = asked.normals,
                      .format = VertexFormat::kFloat32};
  // The most triangles, so that nothing is evaluated in vain.
  if (3 * MostTriangles(plan, spec) >= PolygonMesh::kNoAttribute) {
    return error::LimitExceeded("corners of an export", PolygonMesh::kNoAttribute - 1);
  }
  RenderBackend& backend = input.target->backend();
  LATTICED_ASSIGN_OR_RETURN(const auto target, input.target->Get());
  LATTICED_RETURN_IF_ERROR(CheckSupported(*target, spec));
  LATTICED_ASSIGN_OR_RETURN(auto view, backend.Run([&] { return target->CreateView(spec); }));
  std::vector<uint32_t> chunks(plan.chunk_count());
  std::iota(chunks.begin(), chunks.end(), 0u);
  LATTICED_RETURN_IF_ERROR(stop());
  LATTICED_RETURN_IF_ERROR(
      backend.Run([&] { return view->Evaluate(*state.control_points, state.box, chunks); }));
  if (certified_error != nullptr) *certified_error = view->certified_error();

  SurfaceBuilder surface(state, spec, welding, PatternsOf(*view, plan));
  std::vector<uint8_t> bytes;
  for (const uint32_t chunk : chunks) {
    LATTICED_RETURN_IF_ERROR(stop());
    bytes.resize(ChunkPoints(*view, plan, chunk) * BytesPerPoint(spec));
    LATTICED_RETURN_IF_ERROR(backend.Run([&] { return view->Read(chunk, bytes); }));
    std::span<const uint8_t> rest = bytes;
    const auto [first, last] = plan.ChunkPatches(chunk);
    for (size_t patch = first; patch < last; ++patch) rest = surface.AddPatch(patch, rest);
  }
  return std::move(surface).Finish();
}

SurfaceMemory MemoryOfExactSurface(const DeformPlan& plan, const ViewSpec& spec, Welding welding) {
  const PolygonMesh& mesh = *plan.mesh;
  const bool has_normals = spec.normals != NormalMode::kNone, adaptive = spec.tolerance > 0;
  const uint64_t points = MostPoints(plan, spec), triangles = MostTriangles(plan, spec);
  SurfaceMemory memory;
  WrittenSizes& sizes = memory.sizes;
  sizes = {.positions = adaptive || welding == Welding::kNone
                            ? points
                            : WeldedPoints::Most(plan, spec.segments),
           .normals = has_normals ? points : 0,
           .uvs = mesh.has_uvs() ? points : 0,
           .records = points,
           .corners = 3 * triangles,
           .faces = triangles};
  if (!has_normals && !mesh.has_uvs()) sizes.records = sizes.positions;
  AddGroups(plan, &sizes);
  // A view's vertices, with offsets of its patches and chunks, or twice its vertices with levels of its edges; first numbers
  // of edges and patches; lists of normals and UVs by vertex, twice when short edges
  // are collapsed; torn seams; what short edges become, and their normals and UVs.
  const uint64_t view_bytes_per_patch = adaptive ? 128 : 64;
  constexpr uint64_t kFeatures = 6, kTableBytes = 32;  // corners and edges of torn seams
  const uint64_t lists = (has_normals ? 1u : 0u) + (mesh.has_uvs() ? 1u : 0u);
  memory.working_bytes = (adaptive ? 2 : 1) * points * (has_normals ? 2 : 1) * sizeof(Vec3f) +
                         plan.patches.size() * view_bytes_per_patch +
                         (plan.edges.size() + plan.patches.size()) * sizeof(uint32_t) +
                         2 * lists * (sizes.positions + points) * sizeof(uint32_t) +
                         plan.seam_patches * kFeatures * kTableBytes +
                         (2 * sizes.positions + sizes.faces) * sizeof(uint32_t) +
                         sizes.normals * sizeof(Vec3f) + sizes.uvs * sizeof(Vec2f);
  return memory;
}

}  // namespace latticed
