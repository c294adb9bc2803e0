// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Cutting a mesh at the knot planes, watertight.
//
// All in double, in parameter space. Each source triangle is cut at the u planes, then v, then w, ascending, the six
// faces of the frame included, and then at those of each lattice that is turned against the first. The part of it in a cell is
// a convex polygon. This is triangulated so that its worst triangle is as good as possible.
//
// No crack can appear, because the two triangles of an edge name the same vertices. Mesh vertices at one position are
// one vertex, which is snapped to planes once. A cut point is keyed by its edge's two vertices and the plane. It is
// computed once, from the end points in canonical order (lexicographic by world position).
//
// With weights (weights/vertex_weights.h), mesh vertices are one vertex where their weights are equal too. A cut point has the
// weight of its place on the edge.
//
// Errors   kResourceExhausted past limits::kMaxPatches; kInvalidArgument for a face that takes too long to triangulate;
//          what `stop` returns
// Threads  pure function
#ifndef LATTICED_CORE_FFD_PLAN_KNOT_SPLIT_H_
#define LATTICED_CORE_FFD_PLAN_KNOT_SPLIT_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

struct SplitVertex {
  Vec3d world;
  Vec3d parameter;  // exactly the knot where the vertex is on a plane
  double weight = 1;
};

// A sub-triangle: three vertices, and where they are in the source triangle.
struct SplitPiece {
  std::array<uint32_t, 3> vertex{};
  std::array<std::array<double, 3>, 3> barycentrics{};
  uint32_t triangle = 0;  // index into SplitMesh::triangles
};

// A triangle of the triangulated source: its face, and its three corners in the mesh.
struct SourceTriangle {
  uint32_t face = 0;
  std::array<uint32_t, 3> corners{};
};

struct SplitMesh {
  std::vector<SplitVertex> vertices;
  std::vector<std::vector<Vec3d>> turned;  // by turned lattice: the parameters there, by vertex
  std::vector<SplitPiece> pieces;
  std::vector<SourceTriangle> triangles;
};

// A vertex closer to a knot plane than this fraction of the axis range is on it.
inline constexpr double kPlaneSnap = 0x1p-40;

// `weights` is empty, or has one for each position of the mesh.
[[nodiscard]] absl::StatusOr<SplitMesh> SplitAtKnots(const PolygonMesh& mesh,
                                                     const LatticeStructure& structure,
                                                     StopCheck stop = NeverStop,
                                                     std::span<const float> weights = {},
                                                     std::span<const LatticeStructure> turned = {});

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_KNOT_SPLIT_H_
