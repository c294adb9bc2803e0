// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes made by formula, for a first run without a download, for tests and benchmarks.
//
//   vase    fluted, with a wall: quads, two n-gons, UVs; closed
//   knot    tube along the (2, 3) torus knot: quads, UVs with seams, normals; closed
//   gear    sharp edges: concave n-gons for the faces, quads for teeth and bore, closed;
//           three groups
//   shell   sea shell, a tube along a helical spiral: triangles; open at its mouth
//   slab    a gently waved sheet: quads, UVs; open
//   beam    a box of 2 x 0.25 x 0.25: 4 quads along x on each side, one at each end, UVs; closed
//
// Units    about two units across, centred near the origin, z up
// Size     the number of faces grows with the square of the resolution; the gear's caps get more corners instead, and the
//          beam always has 18 quads
// Errors   kInvalidArgument for another name, or a resolution out of kMin…kMaxSampleResolution
// Threads  pure and deterministic
#ifndef LATTICED_CORE_MESH_SAMPLE_MESHES_H_
#define LATTICED_CORE_MESH_SAMPLE_MESHES_H_

#include <span>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

inline constexpr int kMinSampleResolution = 1;
inline constexpr int kDefaultSampleResolution = 4;  // knot 5,760 quads, shell 8,664 triangles
inline constexpr int kMaxSampleResolution = 64;     // above a million faces

[[nodiscard]] std::span<const std::string_view> SampleMeshNames();

[[nodiscard]] absl::StatusOr<PolygonMesh> MakeSampleMesh(std::string_view name,
                                                         int resolution = kDefaultSampleResolution);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_SAMPLE_MESHES_H_
