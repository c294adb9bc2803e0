// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/moved_vertices.h"

#include "core/ffd/direct_ffd.h"

namespace latticed::client {

PolygonMesh WithMovedVertices(PolygonMesh mesh, const Lattice& lattice) {
  for (Vec3d& vertex : mesh.positions) {
    vertex = EvaluateWorld(lattice.structure, lattice.control_points, vertex).position;
  }
  mesh.normals.clear();
  mesh.corner_normals.clear();
  return mesh;
}

}  // namespace latticed::client
