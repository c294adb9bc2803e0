// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The commands of latticectl, one file each. Add… declares a command's options and its action.
// Parsing sets CommandLine::action to the action of the command that the line names.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_H_

#include <functional>

#include "absl/status/status.h"
#include "client/cpp/latticectl/interruption.h"
#include "client/cpp/latticectl/latticectl_app.h"

namespace CLI {
class App;
}

namespace latticed::client {

struct CommandLine {
  Console console;
  std::function<absl::Status()> action;
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

// Adds all of the commands below.
void AddCommands(CLI::App& app, CommandLine& line);

void AddInfoCommand(CLI::App& app, CommandLine& line);
void AddSampleCommand(CLI::App& app, CommandLine& line);
void AddMeshCommands(CLI::App& app, CommandLine& line);  // upload, meshes [delete]
void AddLatticeCommand(CLI::App& app, CommandLine& line);
void AddApplyCommand(CLI::App& app, CommandLine& line);
void AddSceneCommands(CLI::App& app, CommandLine& line);  // scene create|list|show|delete
void AddEditCommands(CLI::App& app, CommandLine& line);   // edit move|set|drag|…
void AddPickCommand(CLI::App& app, CommandLine& line);
void AddWatchCommand(CLI::App& app, CommandLine& line);
void AddExportCommand(CLI::App& app, CommandLine& line);
inline constexpr char kBenchExample[] =
    "bench knot --editors 2 --edits 200 --server 127.0.0.1:50151";
void AddBenchCommand(CLI::App& app, CommandLine& line);  // starts latticectl-bench
void AddQuickstartCommand(CLI::App& app, CommandLine& line);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_H_
