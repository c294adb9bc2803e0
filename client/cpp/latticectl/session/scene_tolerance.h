// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A tolerance of the command line in the world units of a scene.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_TOLERANCE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_TOLERANCE_H_

#include <string>

#include "absl/status/status.h"
#include "client/cpp/latticectl/command_line/tolerance_flag.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

// Sets the tolerance of the view; nothing if none was given. Asks the server for the scene's unit, or for the corners of
// its patches, where the tolerance needs them.
[[nodiscard]] absl::Status SetTolerance(Client& client, const std::string& scene,
                                        const Tolerance& tolerance, v1::ViewOptions* view);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_TOLERANCE_H_
