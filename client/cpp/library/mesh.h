// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a triangle mesh from decoded points, with the triangles of the patterns. GetTopology's
// provenance adds texture coordinates and groups of the source mesh.
//
//   vertex order  patch by patch, in pattern order within a patch. It depends only on mesh, knots,
//                 frame and segments, never on control points, unless the view has a tolerance
//   uv            of point (i0, i1, i2) of a patch: sum over patch corners c, triangle corners k of
//                 i_c / denominator * barycentrics[3 c + k] * uv(corner k)
//
// Errors   kDataLoss when layouts and points contradict each other
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_MESH_H_
#define LATTICED_CLIENT_CPP_LIBRARY_MESH_H_

#include <span>

#include "absl/status/statusor.h"
#include "client/cpp/library/patch_layout.h"
#include "client/cpp/library/vertex_decoder.h"
#include "core/mesh/polygon_mesh.h"
#include "core/mesh/triangle_mesh.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

// `layouts`: Surface::Layouts.
[[nodiscard]] absl::StatusOr<TriangleMesh> AssembleMesh(std::span<const PatchLayout> layouts,
                                                        DecodedPoints points);

// Adds texture coordinates and groups of `source`, the uploaded mesh. `provenance` is the whole
// result of GetTopology.
[[nodiscard]] absl::Status CarryAttributes(const PolygonMesh& source,
                                           std::span<const PatchLayout> layouts,
                                           const v1::TopologyPart& provenance, TriangleMesh* mesh);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_MESH_H_
