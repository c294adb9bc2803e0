// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A polygon mesh as the triangles of formats that have no polygons. Corners with the same position and texture
// coordinate share a vertex. A corner without a texture coordinate gets (0, 0). Groups are kept, normals are not.
//
// Errors   kInvalidArgument naming a face that has too many corners to divide (core/mesh/triangulate.h)
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TRIANGULATED_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TRIANGULATED_H_

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed::client {

[[nodiscard]] absl::StatusOr<TriangleMesh> Triangulated(const PolygonMesh& mesh);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TRIANGULATED_H_
