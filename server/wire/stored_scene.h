// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a store keeps of a scene beside its edits, and the scene's configuration from it.
//
// Errors   kDataLoss
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_STORED_SCENE_H_
#define LATTICED_SERVER_WIRE_STORED_SCENE_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "latticed/v1/scene.pb.h"
#include "server/engine/scene.h"
#include "server/stores/mesh_store.h"

namespace latticed {

// The header of the scene that `config` was made for from `request`.
[[nodiscard]] std::string StoredHeaderOf(const v1::CreateSceneRequest& request,
                                         const SceneConfig& config);
// What is known of a scene before it is made again.
struct StoredScene {
  std::string mesh_id;
  absl::Duration idle_ttl;
};
[[nodiscard]] absl::StatusOr<StoredScene> StoredSceneOf(std::string_view header);
// As lists show it, without what changes with edits. Headers of older servers have none of it.
[[nodiscard]] absl::StatusOr<v1::Scene> ListedScene(std::string_view header);
// `mesh` is that mesh.
[[nodiscard]] absl::StatusOr<SceneConfig> SceneConfigFromStored(std::string_view header,
                                                                const StoredMesh& mesh);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_STORED_SCENE_H_
