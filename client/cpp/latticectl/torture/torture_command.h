// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_COMMAND_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_COMMAND_H_

#include "client/cpp/latticectl/command_line/command_line.h"

namespace CLI {
class App;
}

namespace latticed::client {

void AddTortureCommand(CLI::App& app, CommandLine& line);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_COMMAND_H_
