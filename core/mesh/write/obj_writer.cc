// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include <iterator>
#include <string>

#include "core/mesh/mesh_reading.h"
#include "core/mesh/write/write_mesh.h"
#include "core/mesh/write/writing_memory.h"
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

bool BeginsGroup(const PolygonMesh& mesh, size_t face) {
  return !mesh.face_groups.empty() &&
         (face == 0 || mesh.face_groups[face] != mesh.face_groups[face - 1]);
}

uint32_t IndexOrNone(const std::vector<uint32_t>& indices, size_t corner) {
  return indices.empty() ? PolygonMesh::kNoAttribute : indices[corner];
}

// The lines of an OBJ file that name its material libraries, the first ones if they are many.
std::string MaterialLibraries(std::string_view source) {
  std::string lines;
  while (!source.empty()) {
    std::string_view line = TakeTextLine(&source);
    if (line.ends_with('\\') || lines.size() + line.size() >= kMostLibraryBytes) continue;
    if (std::string_view rest = line; TakeWord(&rest) != "mtllib") continue;
    lines.append(line);
    lines.push_back('\n');
  }
  return lines;
}

void AppendFace(const PolygonMesh& mesh, size_t face, std::string* out) {
  out->push_back('f');
  for (size_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
    AppendCorner(mesh.corner_vertices[c], IndexOrNone(mesh.corner_uvs, c),
                 IndexOrNone(mesh.corner_normals, c), out);
  }
  out->push_back('\n');
}

}  // namespace

std::string WriteObj(const PolygonMesh& mesh, const FileExtras& extras) {
  const std::string libraries =
      extras.source_format == MeshFormat::kObj ? MaterialLibraries(extras.source) : std::string();
  std::string out;
  // Pages that are not written take no memory.
  out.reserve(libraries.size() + MostObjBytes(WrittenSizesOf(mesh)));
  if (extras.units.known()) {
    fmt::format_to(std::back_inserter(out), "# {}\n", Describe(extras.units));
  }
  out += libraries;
  AppendVertices(mesh.positions, mesh.uvs, mesh.normals, &out);
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    if (BeginsGroup(mesh, f)) AppendGroup(mesh.group_names[mesh.face_groups[f]], &out);
    AppendFace(mesh, f, &out);
  }
  return out;
}

}  // namespace latticed
