// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Ordinary free-form deformation: only the vertices of a mesh move.
//                    Sederberg & Parry 1986, "Free-form deformation of solid geometric models", doi:10.1145/15886.15903
//
//   x -> R(u(x)) for each vertex x   R, and what happens outside the lattice: core/ffd/direct_ffd.h
//
// Faces, texture coordinates and groups stay. Normals are removed: those of the source are wrong after a deformation.
//
// Units    world units, in double
// Errors   none: the lattice and the mesh are validated where they are read
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_MOVED_VERTICES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_MOVED_VERTICES_H_

#include "core/ffd/lattice.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed::client {

[[nodiscard]] PolygonMesh WithMovedVertices(PolygonMesh mesh, const Lattice& lattice);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_MOVED_VERTICES_H_
