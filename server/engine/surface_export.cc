// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/surface_export.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "core/backend.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/mesh/writing_memory.h"

namespace latticed {
namespace {

// The number of patches whose control nets one call computes: enough to keep the backend busy. Cancellation is
// checked between the calls.
constexpr size_t kNetBlock = 4096;

absl::Status CancelledError() { return absl::CancelledError("the export was cancelled"); }

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

void AppendUvs(const DeformPlan& plan, const TessellationPattern& pattern, TriangleMesh& mesh) {
  const auto s = static_cast<double>(pattern.segments);
  mesh.uvs.reserve(plan.patches.size() * pattern.points.size());
  for (const PatchSource& source : plan.sources) {
    const std::array<Vec2f, 3> corners = CornerUvs(*plan.mesh, source);
    for (const auto& point : pattern.points) {
      double u = 0, v = 0;
      for (size_t c = 0; c < 3; ++c) {
        u += point[c] / s * double{corners[c].x};
        v += point[c] / s * double{corners[c].y};
      }
      mesh.uvs.push_back({static_cast<float>(u), static_cast<float>(v)});
    }
  }
}

void AppendTriangles(const DeformPlan& plan, const TessellationPattern& pattern,
                     TriangleMesh& mesh) {
  const PolygonMesh& source = *plan.mesh;
  const auto points = static_cast<uint32_t>(pattern.points.size());
  mesh.triangles.reserve(plan.patches.size() * pattern.triangles.size());
  for (uint32_t patch = 0; patch < plan.patches.size(); ++patch) {
    const uint32_t first = patch * points;
    for (const auto& t : pattern.triangles) {
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  if (source.face_groups.empty()) return;
  mesh.group_names = source.group_names;
  mesh.triangle_groups.reserve(mesh.triangles.size());
  for (const PatchSource& patch : plan.sources) {
    mesh.triangle_groups.insert(mesh.triangle_groups.end(), pattern.triangles.size(),
                                source.face_groups[patch.face]);
  }
}

// Appends vertices from interleaved float32 x y z [nx ny nz], relative to `origin`.
void AppendVertices(const std::vector<uint8_t>& bytes, size_t bytes_per_point, Vec3d origin,
                    TriangleMesh& mesh) {
  const bool normals = bytes_per_point > sizeof(Vec3f);
  for (size_t at = 0; at + bytes_per_point <= bytes.size(); at += bytes_per_point) {
    Vec3f position, normal;
    std::memcpy(&position, &bytes[at], sizeof(Vec3f));
    mesh.positions.push_back(origin + ToDouble(position));
    if (!normals) continue;
    std::memcpy(&normal, &bytes[at + sizeof(Vec3f)], sizeof(Vec3f));
    mesh.normals.push_back(normal);
  }
}

template <typename T>
void AppendBytes(const T& value, std::string& out) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// The vertices of a chunk, and what does not grow with the surface.
constexpr uint64_t kSmallBytes = uint64_t{128} << 10;
// Of a name that is kept, besides its characters.
constexpr uint64_t kGroupBytes = sizeof(std::string) + 32;
// Besides its vertices, a view has offsets of patches and chunks.
constexpr uint64_t kViewBytesPerPatch = 64;

WrittenSizes SizesOf(const DeformPlan& plan, const ExportSpec& spec) {
  const uint64_t patches = plan.patches.size();
  const PolygonMesh& mesh = *plan.mesh;
  WrittenSizes sizes{.points = patches * static_cast<uint64_t>(PointsPerPatch(spec.segments)),
                     .triangles = patches * static_cast<uint64_t>(TrianglesPerPatch(spec.segments)),
                     .has_normals = spec.normals != NormalMode::kNone,
                     .has_uvs = mesh.has_uvs()};
  if (mesh.face_groups.empty()) return sizes;
  sizes.groups = mesh.group_names.size();
  for (const std::string& name : mesh.group_names) sizes.name_bytes += name.size();
  uint32_t last = PolygonMesh::kNoAttribute;
  for (const PatchSource& source : plan.sources) {
    const uint32_t group = mesh.face_groups[source.face];
    if (std::exchange(last, group) == group) continue;
    ++sizes.group_lines;
    sizes.group_line_bytes += mesh.group_names[group].size();
  }
  return sizes;
}

}  // namespace

uint64_t ExportMemoryBytes(const DeformPlan& plan, const ExportSpec& spec) {
  const uint64_t patches = plan.patches.size();
  if (!spec.format.has_value()) {
    const auto n = static_cast<uint64_t>(plan.structure.patch_degree());
    const uint64_t net_bytes = (n + 1) * (n + 2) / 2 * sizeof(Vec3d);
    return (patches + std::min<uint64_t>(patches, kNetBlock)) * net_bytes + kSmallBytes;
  }
  const WrittenSizes sizes = SizesOf(plan, spec);
  const uint64_t mesh_bytes =
      sizes.points * (sizeof(Vec3d) + (sizes.has_normals ? sizeof(Vec3f) : 0) +
                      (sizes.has_uvs ? sizeof(Vec2f) : 0)) +
      sizes.triangles * (3 + (sizes.groups > 0 ? 1 : 0)) * sizeof(uint32_t) +
      sizes.groups * kGroupBytes + sizes.name_bytes;
  const uint64_t view_bytes =
      sizes.points * (sizeof(Vec3f) + (sizes.has_normals ? sizeof(Vec3f) : 0)) +
      patches * kViewBytesPerPatch;
  return mesh_bytes + std::max(view_bytes, MostWritingBytes(*spec.format, sizes)) + kSmallBytes;
}

absl::StatusOr<TriangleMesh> AssembleSurface(const RenderInput& input, int segments,
                                             NormalMode normals, const Cancelled& cancelled) {
  const SceneState& state = *input.state;
  const DeformPlan& plan = *state.plan;
  const ViewSpec spec{.segments = segments, .normals = normals, .format = VertexFormat::kFloat32};
  const uint64_t points =
      uint64_t{plan.patches.size()} * static_cast<uint64_t>(PointsPerPatch(segments));
  if (points > PolygonMesh::kNoAttribute) {
    return error::LimitExceeded("points of an export", PolygonMesh::kNoAttribute);
  }
  RenderBackend& backend = input.target->backend();
  LATTICED_ASSIGN_OR_RETURN(const auto target, input.target->Get());
  LATTICED_ASSIGN_OR_RETURN(auto view, backend.Run([&] { return target->CreateView(spec); }));
  std::vector<uint32_t> chunks(plan.chunk_count());
  std::iota(chunks.begin(), chunks.end(), 0u);
  if (cancelled()) return CancelledError();
  LATTICED_RETURN_IF_ERROR(
      backend.Run([&] { return view->Evaluate(*state.control_points, state.box, chunks); }));

  TriangleMesh mesh;
  mesh.positions.reserve(points);
  if (normals != NormalMode::kNone) mesh.normals.reserve(points);
  std::vector<uint8_t> bytes;
  for (const uint32_t chunk : chunks) {
    if (cancelled()) return CancelledError();
    bytes.resize(ChunkPoints(plan, chunk, segments) * BytesPerPoint(spec));
    LATTICED_RETURN_IF_ERROR(backend.Run([&] { return view->Read(chunk, bytes); }));
    AppendVertices(bytes, BytesPerPoint(spec), plan.local_origin, mesh);
  }
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  if (plan.mesh->has_uvs()) AppendUvs(plan, pattern, mesh);
  AppendTriangles(plan, pattern, mesh);
  return mesh;
}

absl::StatusOr<std::string> WriteControlNets(const RenderInput& input, const Cancelled& cancelled) {
  const SceneState& state = *input.state;
  const DeformPlan& plan = *state.plan;
  LATTICED_ASSIGN_OR_RETURN(const auto target, input.target->Get());
  const auto n = static_cast<uint32_t>(plan.structure.patch_degree());
  const uint32_t m = (n + 1) * (n + 2) / 2;
  std::string out("LATTNETS");
  AppendBytes(uint32_t{1}, out);
  AppendBytes(n, out);
  AppendBytes(m, out);
  AppendBytes(uint32_t{0}, out);
  AppendBytes(uint64_t{plan.patches.size()}, out);
  out.reserve(out.size() + plan.patches.size() * m * sizeof(Vec3d));
  for (size_t first = 0; first < plan.patches.size(); first += kNetBlock) {
    if (cancelled()) return CancelledError();
    const size_t last = std::min(first + kNetBlock, plan.patches.size());
    LATTICED_ASSIGN_OR_RETURN(const auto nets, input.target->backend().Run([&] {
      return target->ControlNets(*state.control_points, first, last);
    }));
    out.append(reinterpret_cast<const char*>(nets.data()), nets.size() * sizeof(double));
  }
  return out;
}

absl::StatusOr<std::string> ExportSurface(const RenderInput& input, const ExportSpec& spec,
                                          const Cancelled& cancelled) {
  if (!spec.format.has_value()) return WriteControlNets(input, cancelled);
  LATTICED_ASSIGN_OR_RETURN(auto mesh,
                            AssembleSurface(input, spec.segments, spec.normals, cancelled));
  mesh.units = spec.units;
  if (*spec.format == MeshFormat::kDraco) {
    return WriteDracoMesh(mesh, spec.position_bits, spec.normal_bits);
  }
  return WriteMesh(*spec.format, mesh);
}

std::string_view ExportMediaType(std::optional<MeshFormat> format) {
  if (!format.has_value()) return "application/octet-stream";
  switch (*format) {
    case MeshFormat::kObj:
      return "model/obj";
    case MeshFormat::kStl:
      return "model/stl";
    case MeshFormat::kGlb:
      return "model/gltf-binary";
    case MeshFormat::kPly:
    case MeshFormat::kDraco:
      break;
  }
  return "application/octet-stream";  // neither has a registered type
}

std::string_view ExportExtension(std::optional<MeshFormat> format) {
  return format.has_value() ? MeshFormatExtension(*format) : "nets";
}

}  // namespace latticed
