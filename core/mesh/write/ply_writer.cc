// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Binary little endian PLY: float x y z [nx ny nz] [s t], then `list uchar int vertex_indices`, or `list uint int` if a
// face has more than 255 corners.
#include <algorithm>
#include <limits>

#include "core/mesh/little_endian.h"
#include "core/mesh/write/vertex_records.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"

namespace latticed {
namespace {

bool HasLongFaces(const PolygonMesh& mesh) {
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_offsets[f + 1] - mesh.face_offsets[f] > std::numeric_limits<uint8_t>::max()) {
      return true;
    }
  }
  return false;
}

std::string PlyHeaderOf(const PolygonMesh& mesh, const MeshUnits& units, size_t vertices,
                        bool long_faces) {
  std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment latticed\n{}element vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n",
      units.known() ? fmt::format("comment {}\n", Describe(units)) : "", vertices);
  if (mesh.has_normals()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (mesh.has_uvs()) header += "property float s\nproperty float t\n";
  header += fmt::format("element face {}\nproperty list {} int vertex_indices\nend_header\n",
                        mesh.face_count(), long_faces ? "uint" : "uchar");
  return header;
}

}  // namespace

std::string WritePly(const PolygonMesh& mesh, const FileExtras& extras) {
  const VertexRecords vertices = MakeVertexRecords(mesh);
  const bool long_faces = HasLongFaces(mesh);
  std::string out = PlyHeaderOf(mesh, extras.units, vertices.records.size(), long_faces);
  const size_t vertex_bytes = sizeof(Vec3f) + (mesh.has_normals() ? sizeof(Vec3f) : 0) +
                              (mesh.has_uvs() ? sizeof(Vec2f) : 0);
  out.reserve(out.size() + vertex_bytes * vertices.records.size() +
              (long_faces ? sizeof(uint32_t) : 1) * mesh.face_count() +
              sizeof(uint32_t) * mesh.corner_count());
  for (const VertexRecord& record : vertices.records) {
    AppendLittleEndian(ToFloat(mesh.positions[record.position]), &out);
    if (mesh.has_normals()) AppendLittleEndian(NormalOf(mesh, record), &out);
    if (mesh.has_uvs()) AppendLittleEndian(UvOf(mesh, record), &out);
  }
  for (size_t f = 0; f < mesh.face_count(); ++f) {
    const uint32_t first = mesh.face_offsets[f], end = mesh.face_offsets[f + 1];
    if (long_faces)
      AppendLittleEndian(end - first, &out);
    else
      AppendLittleEndian(static_cast<uint8_t>(end - first), &out);
    for (uint32_t c = first; c < end; ++c) AppendLittleEndian(vertices.corner_records[c], &out);
  }
  return out;
}

}  // namespace latticed
