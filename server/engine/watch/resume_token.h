// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a client has, as a token. The client sends it back when it watches again. The token ends with an HMAC, so
// that a changed token resumes nothing. A store may go back in time, as after a failover that lost commits: another run of
// a server takes a token only if it knows the revision by the time of its commit.
//
// Threads  pure
#ifndef LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_
#define LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/functional/function_ref.h"
#include "absl/time/time.h"
#include "server/engine/scene/scene_state.h"
#include "server/engine/watch/next_event.h"

namespace latticed {

// Where a token counts. A scene that is created again under the id of a deleted one begins with the same structure and
// revision numbers, but has another key.
struct TokenScope {
  std::string key;        // of the HMAC: the scene's, which its store keeps secret
  std::string evaluator;  // whatever makes the same bytes from the same lattice has the same name
  std::string run;        // this run of the server
};

[[nodiscard]] std::string MakeResumeToken(const TokenScope& scope, const ClientSurface& had);
// When a revision was committed; nullopt where that is not known, as before the last snapshot of the log.
using CommitTimeOf = absl::FunctionRef<std::optional<absl::Time>(uint64_t revision)>;
// nullopt when the token is of another scope, view or history, or the scene now has another structure or box.
[[nodiscard]] std::optional<ClientSurface> ParseResumeToken(std::string_view token,
                                                            const TokenScope& scope,
                                                            const ViewKey& view,
                                                            const SceneState& state,
                                                            CommitTimeOf committed);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_RESUME_TOKEN_H_
