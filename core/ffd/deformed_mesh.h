// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Ordinary free-form deformation: the vertices of a mesh move, its faces stay.
//                    Sederberg & Parry 1986, "Free-form deformation of solid geometric models", doi:10.1145/15886.15903
//
//   vertex  x -> R(u(x))          R, and what happens outside the lattice: core/ffd/direct_ffd.h
//   normal  cof(J) N / |…|        of each corner, if the mesh has normals; N where that vanishes
//
// With weights, a vertex goes to x + w (R - x), and J has the gradient of the weight in the triangle of a corner and its two
// neighbours in the face (weights/vertex_weights.h).
//
// Vertices, faces, texture coordinates and groups stay as they are. Normals that are nearly the same at a vertex become
// one.
//
// Units    world units, in double
// Errors   what `stop` returns; it is asked every few thousand vertices
// Threads  pure
#ifndef LATTICED_CORE_FFD_DEFORMED_MESH_H_
#define LATTICED_CORE_FFD_DEFORMED_MESH_H_

#include <span>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/ffd/direct_ffd.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

// `deform` is EvaluateWorld of a lattice or a plan. `weights` is empty, or has one for each position.
[[nodiscard]] absl::StatusOr<PolygonMesh> DeformedMesh(
    PolygonMesh mesh, absl::FunctionRef<DeformedPoint(Vec3d)> deform, StopCheck stop = NeverStop,
    std::span<const float> weights = {});

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DEFORMED_MESH_H_
