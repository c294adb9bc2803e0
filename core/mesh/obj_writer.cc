// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include <iterator>
#include <string>

#include "core/mesh/mesh_io.h"
#include "core/mesh/writing_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

void AppendVertices(const std::vector<Vec3d>& positions, const std::vector<Vec2f>& uvs,
                    const std::vector<Vec3f>& normals, std::string* out) {
  const auto end = std::back_inserter(*out);
  for (Vec3d p : positions) fmt::format_to(end, "v {} {} {}\n", p.x, p.y, p.z);
  for (Vec2f uv : uvs) fmt::format_to(end, "vt {} {}\n", uv.x, uv.y);
  for (Vec3f n : normals) fmt::format_to(end, "vn {} {} {}\n", n.x, n.y, n.z);
}

// Indices are from 0, kNoAttribute where there is none.
void AppendCorner(uint32_t vertex, uint32_t uv, uint32_t normal, std::string* out) {
  const auto end = std::back_inserter(*out);
  fmt::format_to(end, " {}", uint64_t{vertex} + 1);
  const bool has_uv = uv != PolygonMesh::kNoAttribute;
  const bool has_normal = normal != PolygonMesh::kNoAttribute;
  if (has_uv) fmt::format_to(end, "/{}", uint64_t{uv} + 1);
  if (has_normal) fmt::format_to(end, "{}{}", has_uv ? "/" : "//", uint64_t{normal} + 1);
}

// A line end or a backslash in a name would change the file's meaning.
void AppendGroup(std::string_view name, std::string* out) {
  fmt::format_to(std::back_inserter(*out), "usemtl ");
  for (char c : name) out->push_back(c == '\n' || c == '\r' || c == '\\' ? '_' : c);
  out->push_back('\n');
}

bool BeginsGroup(const TriangleMesh& mesh, size_t triangle) {
  return !mesh.triangle_groups.empty() &&
         (triangle == 0 || mesh.triangle_groups[triangle] != mesh.triangle_groups[triangle - 1]);
}

WrittenSizes SizesOf(const TriangleMesh& mesh) {
  WrittenSizes sizes{.points = mesh.positions.size(),
                     .triangles = mesh.triangles.size(),
                     .has_normals = !mesh.normals.empty(),
                     .has_uvs = !mesh.uvs.empty()};
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!BeginsGroup(mesh, t)) continue;
    ++sizes.group_lines;
    sizes.group_line_bytes += mesh.group_names[mesh.triangle_groups[t]].size();
  }
  return sizes;
}

uint32_t IndexOrNone(const std::vector<uint32_t>& indices, size_t corner) {
  return indices.empty() ? PolygonMesh::kNoAttribute : indices[corner];
}

}  // namespace

std::string WriteObj(const TriangleMesh& mesh) {
  std::string out;
  out.reserve(MostObjBytes(SizesOf(mesh)));  // pages that are not written take no memory
  if (mesh.units.known()) {
    fmt::format_to(std::back_inserter(out), "# {}\n", Describe(mesh.units));
  }
  AppendVertices(mesh.positions, mesh.uvs, mesh.normals, &out);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (BeginsGroup(mesh, t)) AppendGroup(mesh.group_names[mesh.triangle_groups[t]], &out);
    out.push_back('f');
    for (uint32_t v : mesh.triangles[t]) {
      AppendCorner(v, mesh.uvs.empty() ? PolygonMesh::kNoAttribute : v,
                   mesh.normals.empty() ? PolygonMesh::kNoAttribute : v, &out);
    }
    out.push_back('\n');
  }
  return out;
}

std::string WriteObj(const PolygonMesh& mesh) {
  std::string out;
  AppendVertices(mesh.positions, mesh.uvs, mesh.normals, &out);
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    if (!mesh.face_groups.empty() && (f == 0 || mesh.face_groups[f] != mesh.face_groups[f - 1])) {
      AppendGroup(mesh.group_names[mesh.face_groups[f]], &out);
    }
    out.push_back('f');
    for (size_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      AppendCorner(mesh.corner_vertices[c], IndexOrNone(mesh.corner_uvs, c),
                   IndexOrNone(mesh.corner_normals, c), &out);
    }
    out.push_back('\n');
  }
  return out;
}

}  // namespace latticed
