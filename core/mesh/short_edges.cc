// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/short_edges.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/mesh/vertex_values.h"

namespace latticed {
namespace {

// Which vertex each vertex becomes: the one of the lowest number that short edges lead to.
class MergedVertices {
 public:
  explicit MergedVertices(const PolygonMesh& mesh) {
    const double shortest = ShortEdgeLength(mesh.ComputeBounds());
    for (size_t c = 0; c < mesh.corner_count(); ++c) {
      const uint32_t a = mesh.corner_vertices[c];
      const uint32_t b = mesh.corner_vertices[c % 3 == 2 ? c - 2 : c + 1];
      if (Norm(mesh.positions[a] - mesh.positions[b]) > shortest) continue;
      has_short_edges_ = true;
      if (target_.empty()) Begin(mesh.positions.size());
      const uint32_t p = Root(a), q = Root(b);
      target_[std::max(p, q)] = std::min(p, q);
    }
    for (uint32_t v = 0; v < target_.size(); ++v) target_[v] = Root(v);
  }

  bool has_short_edges() const { return has_short_edges_; }
  uint32_t operator[](uint32_t vertex) const { return target_[vertex]; }

 private:
  void Begin(size_t vertices) {
    target_.resize(vertices);
    std::iota(target_.begin(), target_.end(), 0u);
  }
  uint32_t Root(uint32_t vertex) {
    while (target_[vertex] != vertex) {
      target_[vertex] = target_[target_[vertex]];
      vertex = target_[vertex];
    }
    return vertex;
  }

  std::vector<uint32_t> target_;
  bool has_short_edges_ = false;
};

bool StaysWhole(const PolygonMesh& mesh, const MergedVertices& merged, size_t triangle) {
  uint32_t v[3];
  for (size_t i = 0; i < 3; ++i) v[i] = merged[mesh.corner_vertices[3 * triangle + i]];
  return v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
}

// Moves the elements of the triangles in `kept` to the front.
template <typename T>
void Keep(const std::vector<uint32_t>& kept, size_t per_triangle, std::vector<T>* values) {
  if (values->empty()) return;
  size_t end = 0;
  for (const uint32_t triangle : kept) {
    for (size_t i = 0; i < per_triangle; ++i) {
      (*values)[end++] = (*values)[per_triangle * triangle + i];
    }
  }
  values->resize(end);
}

// Removes the positions that became others, and numbers the corners anew.
void RemoveMerged(const MergedVertices& merged, PolygonMesh* mesh) {
  std::vector<uint32_t> number(mesh->positions.size());
  uint32_t count = 0;
  for (uint32_t v = 0; v < number.size(); ++v) {
    if (merged[v] != v) continue;
    mesh->positions[count] = mesh->positions[v];
    number[v] = count++;
  }
  mesh->positions.resize(count);
  for (uint32_t& vertex : mesh->corner_vertices) vertex = number[merged[vertex]];
}

// Vertices that became one have nearly the same values.
template <typename T>
void JoinValues(const PolygonMesh& mesh, std::vector<T>* values, std::vector<uint32_t>* corners) {
  VertexValues<T> joined(mesh.positions.size(), values->size());
  for (size_t c = 0; c < corners->size(); ++c) {
    uint32_t& value = (*corners)[c];
    if (value == PolygonMesh::kNoAttribute) continue;
    value = joined.Add(mesh.corner_vertices[c], (*values)[value]);
  }
  *values = std::move(joined).Take();
}

}  // namespace

double ShortEdgeLength(const Bounds& bounds) { return 0x1p-22 * bounds.diagonal(); }

void CollapseShortEdges(PolygonMesh& mesh) {
  const MergedVertices merged(mesh);
  if (!merged.has_short_edges()) return;
  std::vector<uint32_t> kept;
  kept.reserve(mesh.face_count());
  for (uint32_t t = 0; t < mesh.face_count(); ++t) {
    if (StaysWhole(mesh, merged, t)) kept.push_back(t);
  }
  if (kept.empty()) return;
  Keep(kept, 3, &mesh.corner_vertices);
  Keep(kept, 3, &mesh.corner_normals);
  Keep(kept, 3, &mesh.corner_uvs);
  Keep(kept, 1, &mesh.face_groups);
  mesh.face_offsets.resize(kept.size() + 1);
  RemoveMerged(merged, &mesh);
  JoinValues(mesh, &mesh.normals, &mesh.corner_normals);
  JoinValues(mesh, &mesh.uvs, &mesh.corner_uvs);
}

}  // namespace latticed
