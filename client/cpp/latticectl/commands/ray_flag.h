// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A ray on the command line, and the request that picks by it.
//
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_RAY_FLAG_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_RAY_FLAG_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "latticed/v1/surface.pb.h"

namespace latticed::client {

// --ray: six numbers, the ray's origin and its direction.
CLI::Option* AddRayFlag(CLI::App& command, std::vector<double>& ray);
[[nodiscard]] v1::PickRequest PickRequestOf(const std::string& scene,
                                            const std::vector<double>& ray);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_RAY_FLAG_H_
