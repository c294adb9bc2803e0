// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_scenes.h"

#include <utility>

namespace latticed::client {

absl::Status LoadScenes::Make(MeshFile mesh, const v1::CreateSceneRequest& request,
                              Console console) {
  made_.push_back(std::make_unique<TemporaryScene>(client_));
  const auto uploaded = made_.back()->Upload(mesh, {}, console);
  if (!uploaded.ok()) return uploaded.status();
  const auto scene = made_.back()->Create(request);
  if (!scene.ok()) return scene.status();
  scenes_.push_back({scene->id(), std::make_shared<const MeshFile>(std::move(mesh))});
  return absl::OkStatus();
}

}  // namespace latticed::client
