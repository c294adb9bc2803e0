// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scanned and modelled meshes, if this machine has them. They are not part of the project.
#ifndef LATTICED_TESTS_SUPPORT_REAL_MESHES_H_
#define LATTICED_TESTS_SUPPORT_REAL_MESHES_H_

#include <string>
#include <vector>

#include "core/mesh/polygon_mesh.h"

namespace latticed::testing {

struct RealMesh {
  std::string name;
  PolygonMesh mesh;
};

// Every mesh in $LATTICED_SHARED/models, except Draco files, sorted by name; empty without that folder.
// A mesh that cannot be read fails the test.
[[nodiscard]] std::vector<RealMesh> RealMeshes();

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_REAL_MESHES_H_
