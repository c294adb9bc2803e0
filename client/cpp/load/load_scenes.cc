// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_scenes.h"

#include <utility>

#include "core/base/status_macros.h"

namespace latticed::client {

absl::Status LoadScenes::Make(MeshFile mesh, const v1::CreateSceneRequest& request,
                              Console console) {
  made_.push_back(std::make_unique<TemporaryScene>(client_));
  LATTICED_ASSIGN_OR_RETURN(const auto uploaded, made_.back()->Upload(mesh, {}, console));
  LATTICED_ASSIGN_OR_RETURN(const auto scene, made_.back()->Create(request));
  scenes_.push_back({scene.id(), std::make_shared<const MeshFile>(std::move(mesh))});
  return absl::OkStatus();
}

}  // namespace latticed::client
