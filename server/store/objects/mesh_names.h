// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Names of the files and objects of meshes: HASH, and HASH.TENANT where a tenant has the mesh (server/base/auth/tenant.h). No
// hash and no tenant has a dot.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_STORE_OBJECTS_MESH_NAMES_H_
#define LATTICED_SERVER_STORE_OBJECTS_MESH_NAMES_H_

#include <string>
#include <string_view>

namespace latticed {

// Whether a mesh may have this id: a hash, or a tenant's.
[[nodiscard]] bool IsMeshId(std::string_view id);
[[nodiscard]] std::string MeshName(std::string_view id);
// Whether it is the name of a mesh.
[[nodiscard]] bool IsMeshName(std::string_view name);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_MESH_NAMES_H_
