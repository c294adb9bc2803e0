// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a client has, as a token that it gives back when it comes again.
//
// Threads  pure
#ifndef LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_
#define LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/engine/scene/scene_state.h"
#include "server/engine/watch/next_event.h"

namespace latticed {

// Of which scene a token speaks. Structures and revisions begin anew in a scene that is created again
// under the id of a deleted one, and in another run of the server.
struct TokenScope {
  std::string boot_id;
  std::string scene_id;
  uint64_t incarnation = 0;
};

[[nodiscard]] std::string MakeResumeToken(const TokenScope& scope, const ClientSurface& had);
// nullopt where the token is not of this scope and view, or the scene has another structure or box by
// now.
[[nodiscard]] std::optional<ClientSurface> ParseResumeToken(std::string_view token,
                                                            const TokenScope& scope,
                                                            const ViewKey& view,
                                                            const SceneState& state);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_
