// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/temporary_scenes.h"

#include <utility>

#include "client/cpp/latticectl/surface_mesh.h"
#include "core/base/sha256.h"

namespace latticed::client {

// A failed call may have made its scene or mesh: a broken connection loses the reply.
TemporaryScenes::~TemporaryScenes() {
  for (const std::string& scene : scenes_to_delete_) (void)client_.DeleteScene(scene);
  // Without force: a mesh that another client has put into a scene meanwhile stays.
  for (const std::string& mesh : meshes_to_delete_) {
    (void)client_.DeleteMesh(mesh, /*force=*/false);
  }
}

absl::StatusOr<v1::Mesh> TemporaryScenes::Upload(const MeshFile& file, v1::MeshHeader header,
                                                 Console console) {
  const std::string id = Sha256Hex(file.bytes);
  if (absl::IsNotFound(client_.GetMesh(id).status())) meshes_to_delete_.push_back(id);
  auto mesh = client::Upload(client_, file, std::move(header), console);
  if (mesh.ok()) mesh_ = mesh->id();
  return mesh;
}

absl::StatusOr<v1::Scene> TemporaryScenes::Create(v1::CreateSceneRequest request) {
  scenes_to_delete_.push_back(RandomSceneId());
  request.set_scene_id(scenes_to_delete_.back());
  request.set_mesh(mesh_);
  return client_.CreateScene(std::move(request));
}

void TemporaryScenes::Keep() {
  meshes_to_delete_.clear();
  scenes_to_delete_.clear();
}

}  // namespace latticed::client
