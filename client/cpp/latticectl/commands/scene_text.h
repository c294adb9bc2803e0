// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the commands of scenes print. `states` are those of the scene's lattices, as far as they are known: they say what edits
// of each lattice keep, and how much of each the scene takes.
//
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_SCENE_TEXT_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_SCENE_TEXT_H_

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "latticed/v1/lattice.pb.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

[[nodiscard]] std::string ScenesText(const std::vector<v1::Scene>& scenes);
[[nodiscard]] std::string SceneText(const v1::Scene& scene,
                                    std::span<const v1::LatticeState> states = {});
// The proto3 JSON of the scene. Each of its lattices with a state also has "strength", and "constraints" if it has any.
[[nodiscard]] nlohmann::json SceneJson(const v1::Scene& scene,
                                       std::span<const v1::LatticeState> states);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_SCENE_TEXT_H_
