// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of a torus on a server.
#ifndef LATTICED_TESTS_CLIENT_PATCHES_TORUS_SCENE_H_
#define LATTICED_TESTS_CLIENT_PATCHES_TORUS_SCENE_H_

#include <string>

#include "client/cpp/library/latticed_client.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "tests/support/test_meshes.h"

namespace latticed::client {

inline PolygonMesh SceneTorus() { return testing::TorusMesh(24, 16); }

// Uploads the torus, and sets it in `create`.
inline absl::StatusOr<v1::Scene> CreateTorusScene(Client& client, v1::CreateSceneRequest create) {
  const PolygonMesh torus = SceneTorus();
  std::string obj;
  for (const Vec3d& p : torus.positions) obj += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (size_t f = 0; f < torus.face_count(); ++f) {
    obj += "f";
    for (uint32_t c = torus.face_offsets[f]; c < torus.face_offsets[f + 1]; ++c) {
      obj += fmt::format(" {}", torus.corner_vertices[c] + 1);
    }
    obj += "\n";
  }
  v1::MeshHeader header;
  header.set_format(v1::MESH_FORMAT_OBJ);
  LATTICED_ASSIGN_OR_RETURN(const v1::Mesh mesh, client.UploadMesh(obj, header));
  create.set_mesh(mesh.id());
  return client.CreateScene(create);
}

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_PATCHES_TORUS_SCENE_H_
