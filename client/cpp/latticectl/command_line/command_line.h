// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The command line of a program. Parsing sets CommandLine::action to the action of the command that the line names.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_COMMAND_LINE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_COMMAND_LINE_H_

#include <functional>

#include "absl/status/status.h"
#include "client/cpp/latticectl/command_line/interruption.h"
#include "client/cpp/latticectl/output/console.h"

namespace CLI {
class App;
}

namespace latticed::client {

struct CommandLine {
  Console console;
  bool as_json = false;  // failures and notices are JSON
  std::function<absl::Status()> action;
  int exit_code = 0;          // of an action that succeeds
  Interruption interruption;  // for commands that delete what they have made
};

// Makes `run` the action of command lines that name `command` but none of its subcommands.
void SetAction(CLI::App& command, CommandLine& line, std::function<absl::Status()> run);

// Ends the help of `command` with "Example: latticectl …".
void SetExample(CLI::App& command, const char* arguments);

// Parses a command line of `app` and runs the action. Without an action, prints the help of the command or group that
// the line names. Returns the exit codes of RunLatticectl.
[[nodiscard]] int RunCommandLine(CLI::App& app, CommandLine& line, int argc,
                                 const char* const* argv);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_COMMAND_LINE_H_
