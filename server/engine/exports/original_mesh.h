// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The uploaded mesh with its own vertices, faces, texture coordinates and groups, its vertices where the deformation
// moves them (core/ffd/deformed_mesh.h).
//
// Normals  smooth: those of the scene (vertex_normals.h), carried; facet and none: no normals, so faces are flat
// Faces    for formats of triangles, divided as at rest, by the triangles whose exact surface the scene has
// Units    world units, in double
// Errors   what `stop` returns
// Threads  pure functions of an immutable state
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_ORIGINAL_MESH_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_ORIGINAL_MESH_H_

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "server/engine/exports/surface_export.h"
#include "server/engine/exports/surface_memory.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<PolygonMesh> OriginalMesh(const SceneState& state, NormalMode normals,
                                                       bool keeps_polygons, StopCheck stop);

[[nodiscard]] SurfaceMemory MemoryOfOriginalMesh(const DeformPlan& plan, NormalMode normals,
                                                 bool keeps_polygons);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_ORIGINAL_MESH_H_
