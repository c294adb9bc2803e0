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
  explicit MergedVertices(const PolygonMesh& mesh) : mesh_(mesh) {
    const double shortest = ShortEdgeLength(mesh.ComputeBounds());
    most_square_ = shortest * shortest;
    for (size_t c = 0; c < mesh.corner_count(); c += 3) {
      const uint32_t* v = &mesh.corner_vertices[c];
      Visit(v[0], v[1]);
      Visit(v[1], v[2]);
      Visit(v[2], v[0]);
    }
    for (uint32_t v = 0; v < target_.size(); ++v) target_[v] = Root(v);
  }

  bool has_short_edges() const { return !target_.empty(); }
  uint32_t operator[](uint32_t vertex) const { return target_[vertex]; }

 private:
  void Visit(uint32_t a, uint32_t b) {
    if (!AreNear(a, b)) return;
    if (target_.empty()) {
      target_.resize(mesh_.positions.size());
      std::iota(target_.begin(), target_.end(), 0u);
    }
    const uint32_t p = Root(a), q = Root(b);
    if (AreNear(p, q)) target_[std::max(p, q)] = std::min(p, q);  // a chain may be long
  }
  bool AreNear(uint32_t a, uint32_t b) const {
    const Vec3d edge = mesh_.positions[b] - mesh_.positions[a];
    return Dot(edge, edge) <= most_square_;
  }
  uint32_t Root(uint32_t vertex) {
    while (target_[vertex] != vertex) {
      target_[vertex] = target_[target_[vertex]];
      vertex = target_[vertex];
    }
    return vertex;
  }

  const PolygonMesh& mesh_;
  double most_square_ = 0;
  std::vector<uint32_t> target_;
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
