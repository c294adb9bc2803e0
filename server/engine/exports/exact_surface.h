// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The exact deformed surface as a mesh of triangles.
//
//   state -> float view of all chunks, by segments or a tolerance -> welded points, normals, texture coordinates
//
// Vertices   in the order of welded_points.h; patches that share a point share its vertex, unless nothing is welded
// Normals    those of the view; nearly equal ones at a vertex are one, others are a crease
// UVs        interpolated in the source triangle
// Triangles  patch after patch in plan order, in pattern order inside a patch, without slivers (short_edges.h); their
//            groups are those of the source face
// Units      world units; positions were computed as float32 about the plan's local origin
// Errors     kResourceExhausted from the backend or past 2^32 corners, what `stop` returns
// Threads    a pure function of an immutable state; `stop` is asked once a chunk
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_EXACT_SURFACE_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_EXACT_SURFACE_H_

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"
#include "server/engine/exports/surface_export.h"
#include "server/engine/exports/surface_memory.h"
#include "server/engine/exports/welded_points.h"

namespace latticed {

// Only segments, tolerance and normals of `spec` have an effect. Sets `certified_error`, which may be null, to that of the
// view.
[[nodiscard]] absl::StatusOr<PolygonMesh> ExactSurface(const RenderInput& input,
                                                       const ViewSpec& spec, StopCheck stop,
                                                       Welding welding = Welding::kShared,
                                                       double* certified_error = nullptr);

[[nodiscard]] SurfaceMemory MemoryOfExactSurface(const DeformPlan& plan, const ViewSpec& spec,
                                                 Welding welding);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_EXACT_SURFACE_H_
