// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Cutting by knot planes leaves slivers that float32 cannot tell from an edge or a point. Programs that read a file drop
// such triangles, and then the surface is open beside them.
//
//   Two vertices whose edge is at most 2^-22 of the bounds' diagonal long become one, which stays at its place, and so do
//   further ones that are as near to it. Triangles that have it twice go.
//
// 2^-22 is below the tolerance of positions (core/README.md). A mesh of nothing else stays as it is.
//
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_SHORT_EDGES_H_
#define LATTICED_CORE_MESH_SHORT_EDGES_H_

#include "core/mesh/polygon_mesh.h"

namespace latticed {

// The longest edge that is too short.
[[nodiscard]] double ShortEdgeLength(const Bounds& bounds);

// All faces must be triangles.
void CollapseShortEdges(PolygonMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_SHORT_EDGES_H_
