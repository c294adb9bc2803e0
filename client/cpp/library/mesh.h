// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a triangle mesh from decoded points, with the triangles of the pattern. GetTopology's
// provenance adds texture coordinates and groups of the source mesh.
//
//   vertex order  patch by patch, in pattern order within a patch. It depends only on mesh, knots,
//                 frame and segments, never on control points
//   uv            of point (i0, i1, i2) of a patch: sum over patch corners c, triangle corners k of
//                 i_c / segments * barycentrics[3 c + k] * uv(corner k)
//
// Errors   kDataLoss when topology and points contradict each other
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_MESH_H_
#define LATTICED_CLIENT_CPP_LIBRARY_MESH_H_

#include "absl/status/statusor.h"
#include "client/cpp/library/chunks.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"
#include "latticed/v1/event.pb.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

[[nodiscard]] absl::StatusOr<TriangleMesh> AssembleMesh(const v1::Topology& topology,
                                                        DecodedPoints points);

// Adds texture coordinates and groups of `source`, the uploaded mesh. `provenance` is the whole
// result of GetTopology.
[[nodiscard]] absl::Status CarryAttributes(const PolygonMesh& source, const v1::Topology& topology,
                                           const v1::TopologyPart& provenance, TriangleMesh* mesh);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_MESH_H_
