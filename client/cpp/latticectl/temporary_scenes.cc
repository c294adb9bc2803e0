// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/temporary_scene.h"

#include <utility>

#include "client/cpp/latticectl/surface_mesh.h"
#include "core/base/sha256.h"

namespace latticed::client {

// Where making one failed it may be there all the same: of a broken connection the reply is lost.
TemporaryScene::~TemporaryScene() {
  if (!scene_to_delete_.empty()) (void)client_.DeleteScene(scene_to_delete_);
  // A mesh that another has put into a scene meanwhile stays: without force it is not deleted.
  if (!mesh_to_delete_.empty()) (void)client_.DeleteMesh(mesh_to_delete_, /*force=*/false);
}

absl::StatusOr<v1::Mesh> TemporaryScene::Upload(const MeshFile& file, v1::MeshHeader header,
                                                Console console) {
  const std::string id = Sha256Hex(file.bytes);
  if (absl::IsNotFound(client_.GetMesh(id).status())) mesh_to_delete_ = id;
  auto mesh = client::Upload(client_, file, std::move(header), console);
  if (mesh.ok()) mesh_ = mesh->id();
  return mesh;
}

absl::StatusOr<v1::Scene> TemporaryScene::Create(v1::CreateSceneRequest request) {
  scene_to_delete_ = RandomSceneId();
  request.set_scene_id(scene_to_delete_);
  request.set_mesh(mesh_);
  return client_.CreateScene(std::move(request));
}

void TemporaryScene::Keep() {
  mesh_to_delete_.clear();
  scene_to_delete_.clear();
}

}  // namespace latticed::client
