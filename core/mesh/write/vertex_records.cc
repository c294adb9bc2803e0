// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/write/vertex_records.h"

#include <algorithm>

namespace latticed {
namespace {

constexpr uint32_t kNone = PolygonMesh::kNoAttribute;

VertexRecord RecordOf(const PolygonMesh& mesh, size_t corner) {
  return {mesh.corner_vertices[corner], mesh.has_normals() ? mesh.corner_normals[corner] : kNone,
          mesh.has_uvs() ? mesh.corner_uvs[corner] : kNone};
}

VertexRecords OnePerPosition(const PolygonMesh& mesh) {
  VertexRecords result{.records = {}, .corner_records = mesh.corner_vertices};
  result.records.reserve(mesh.positions.size());
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) result.records.push_back({v, kNone, kNone});
  return result;
}

}  // namespace

VertexRecords MakeVertexRecords(const PolygonMesh& mesh) {
  if (!mesh.has_normals() && !mesh.has_uvs()) return OnePerPosition(mesh);
  // The records of a position are a list: few have more than two.
  std::vector<uint32_t> first(mesh.positions.size(), kNone), next;
  std::vector<VertexRecord> found;
  const size_t expected = std::max({mesh.positions.size(), mesh.normals.size(), mesh.uvs.size()});
  next.reserve(expected);
  found.reserve(expected);
  VertexRecords result;
  result.corner_records.reserve(mesh.corner_count());
  for (size_t corner = 0; corner < mesh.corner_count(); ++corner) {
    const VertexRecord record = RecordOf(mesh, corner);
    uint32_t* place = &first[record.position];
    while (*place != kNone && found[*place] != record) place = &next[*place];
    if (*place == kNone) {
      *place = static_cast<uint32_t>(found.size());  // before `next` grows, which may move it
      result.corner_records.push_back(*place);
      found.push_back(record);
      next.push_back(kNone);
    } else {
      result.corner_records.push_back(*place);
    }
  }
  // In order of position.
  std::vector<uint32_t> number(found.size());
  result.records.reserve(found.size());
  for (const uint32_t begin : first) {
    for (uint32_t i = begin; i != kNone; i = next[i]) {
      number[i] = static_cast<uint32_t>(result.records.size());
      result.records.push_back(found[i]);
    }
  }
  for (uint32_t& record : result.corner_records) record = number[record];
  return result;
}

}  // namespace latticed
