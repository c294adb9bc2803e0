// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/write/vertex_records.h"

#include <algorithm>
#include <utility>

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

// The records of each position as a list. Few positions have more than two; the hub of a hostile fan has as many as the
// mesh has faces.
class RecordLists {
 public:
  explicit RecordLists(const PolygonMesh& mesh)
      : first_(mesh.positions.size(), kNone), last_(mesh.positions.size(), kNone) {
    const size_t expected =
        std::min(mesh.corner_count(),
                 std::max({mesh.positions.size(), mesh.normals.size(), mesh.uvs.size()}));
    next_.reserve(expected);
    found_.reserve(expected);
  }

  uint32_t Add(const VertexRecord& record) {
    constexpr int kMostCompared = 32;
    int left = kMostCompared;
    for (uint32_t i = first_[record.position]; i != kNone && left > 0; i = next_[i], --left) {
      if (found_[i] == record) return i;
    }
    const auto added = static_cast<uint32_t>(found_.size());
    found_.push_back(record);
    next_.push_back(kNone);
    const uint32_t last = std::exchange(last_[record.position], added);
    (last == kNone ? first_[record.position] : next_[last]) = added;
    return added;
  }

  // Appends the records in order of position. Returns the number of each.
  std::vector<uint32_t> TakeInOrder(std::vector<VertexRecord>* records) const {
    std::vector<uint32_t> number(found_.size());
    records->reserve(found_.size());
    for (const uint32_t begin : first_) {
      for (uint32_t i = begin; i != kNone; i = next_[i]) {
        number[i] = static_cast<uint32_t>(records->size());
        records->push_back(found_[i]);
      }
    }
    return number;
  }

 private:
  std::vector<uint32_t> first_, last_, next_;
  std::vector<VertexRecord> found_;
};

}  // namespace

VertexRecords MakeVertexRecords(const PolygonMesh& mesh) {
  if (!mesh.has_normals() && !mesh.has_uvs()) return OnePerPosition(mesh);
  RecordLists lists(mesh);
  VertexRecords result;
  result.corner_records.reserve(mesh.corner_count());
  for (size_t corner = 0; corner < mesh.corner_count(); ++corner) {
    result.corner_records.push_back(lists.Add(RecordOf(mesh, corner)));
  }
  const std::vector<uint32_t> number = lists.TakeInOrder(&result.records);
  for (uint32_t& record : result.corner_records) record = number[record];
  return result;
}

}  // namespace latticed
