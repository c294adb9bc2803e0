// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Errors of stores. Those of the medium have the reason STORE, and say when to try again.
#ifndef LATTICED_SERVER_STORE_STORE_ERRORS_H_
#define LATTICED_SERVER_STORE_STORE_ERRORS_H_

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"

namespace latticed::error {

// RESOURCE_EXHAUSTED: the medium has no room.
[[nodiscard]] absl::Status StoreFull(std::string_view problem);
// RESOURCE_EXHAUSTED: too much waits to be written.
[[nodiscard]] absl::Status StoreBusy(uint64_t waiting_bytes, uint64_t most_bytes);
// UNAVAILABLE: the medium failed in another way.
[[nodiscard]] absl::Status StoreFailed(std::string_view problem);
// DATA_LOSS. `what` names the damaged thing: "scene 'gear': record 17".
[[nodiscard]] absl::Status Damaged(std::string_view what, std::string_view problem);
// FAILED_PRECONDITION: the caller's mistake.
[[nodiscard]] absl::Status NotNextRecord(std::string_view scene, uint64_t next, uint64_t got);
// ABORTED: the scene belongs to another server, or to none; claim it.
[[nodiscard]] absl::Status SceneNotOwned(std::string_view scene);
// ABORTED: the answer to an append was lost; claim the scene and read it.
[[nodiscard]] absl::Status RecordInDoubt(std::string_view scene);
// UNAVAILABLE with this reason: another server has the scene. `owner` is its name, empty if it is not known.
inline constexpr char kSceneMovedReason[] = "SCENE_MOVED";
[[nodiscard]] absl::Status SceneMoved(std::string_view owner);
[[nodiscard]] bool IsSceneMoved(const absl::Status& status);
// Whether the medium caused it: not a mistake of the caller, nor something that does not exist or exists
// already, nor a scene of another server.
[[nodiscard]] bool IsOfMedium(const absl::Status& status);

}  // namespace latticed::error

#endif  // LATTICED_SERVER_STORE_STORE_ERRORS_H_
