// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertices of formats that keep all attributes of a vertex in one record (PLY, GLB, Draco): each combination of
// position, normal and texture coordinate that a corner of the mesh has, once.
//
//   records          in order of their position's index, then of their first corner. Without attributes record i is
//                    position i, and positions that no corner uses are among them
//   corner_records   the record of each corner
//
// A position with more than 32 of them may have some twice.
//
// Threads  pure
#ifndef LATTICED_CORE_MESH_WRITE_VERTEX_RECORDS_H_
#define LATTICED_CORE_MESH_WRITE_VERTEX_RECORDS_H_

#include <cstdint>
#include <vector>

#include "core/mesh/polygon_mesh.h"

namespace latticed {

// Indices into the mesh's arrays; kNoAttribute where the corner has none.
struct VertexRecord {
  uint32_t position, normal, uv;

  friend bool operator==(const VertexRecord&, const VertexRecord&) = default;
};

struct VertexRecords {
  std::vector<VertexRecord> records;
  std::vector<uint32_t> corner_records;
};

[[nodiscard]] VertexRecords MakeVertexRecords(const PolygonMesh& mesh);

// The attribute of a record; zeros where the corner has none.
[[nodiscard]] inline Vec3f NormalOf(const PolygonMesh& mesh, const VertexRecord& record) {
  return record.normal == PolygonMesh::kNoAttribute ? Vec3f{} : mesh.normals[record.normal];
}
[[nodiscard]] inline Vec2f UvOf(const PolygonMesh& mesh, const VertexRecord& record) {
  return record.uv == PolygonMesh::kNoAttribute ? Vec2f{} : mesh.uvs[record.uv];
}

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_WRITE_VERTEX_RECORDS_H_
