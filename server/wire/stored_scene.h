// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a store keeps of a scene beside its edits, and the scene's configuration from it.
//
// Errors   kDataLoss
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_STORED_SCENE_H_
#define LATTICED_SERVER_WIRE_STORED_SCENE_H_

#include <optional>
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

// The header without what must not leave the server: the secret of its tokens, and the name of its tenant.
[[nodiscard]] absl::StatusOr<std::string> HeaderForCopy(std::string_view header);
// The configuration of a scene in a copy, which anybody may have written: everything is checked, and the header is made
// anew. `owner`, where given, becomes the owner. kInvalidArgument as of a request that makes such a scene; kDataLoss.
[[nodiscard]] absl::StatusOr<SceneConfig> SceneConfigFromCopy(
    std::string_view header, const StoredMesh& mesh, const std::optional<std::string>& owner);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_STORED_SCENE_H_
