// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A polygon mesh with every face divided into triangles by the rule of triangulate.h. Vertices, normals, texture
// coordinates and groups stay; the triangles of a face follow each other.
//
// Errors   kInvalidArgument naming a face that takes too many tests to divide; what `stop` returns
// Threads  pure
#ifndef LATTICED_CORE_MESH_TRIANGULATED_H_
#define LATTICED_CORE_MESH_TRIANGULATED_H_

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

[[nodiscard]] bool IsTriangular(const PolygonMesh& mesh);
[[nodiscard]] absl::StatusOr<PolygonMesh> Triangulated(const PolygonMesh& mesh,
                                                       StopCheck stop = NeverStop);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_TRIANGULATED_H_
