// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/latticectl_app.h"

#include <CLI/CLI.hpp>

#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/torture/torture_command.h"

namespace latticed::client {

void AddCommands(CLI::App& app, CommandLine& line) {
  app.require_subcommand(0, 1);
  AddInfoCommand(app, line);
  AddSampleCommand(app, line);
  AddMeshCommands(app, line);
  AddLatticeCommand(app, line);
  AddApplyCommand(app, line);
  AddSceneCommands(app, line);
  AddEditCommands(app, line);
  AddPickCommand(app, line);
  AddFoldsCommand(app, line);
  AddMeasureCommand(app, line);
  AddWatchCommand(app, line);
  AddExportCommand(app, line);
  AddPointsCommands(app, line);
  AddBenchCommand(app, line);
  AddShareCommands(app, line);
  AddBackupCommands(app, line);
  AddStoreCommand(app, line);
  AddTortureCommand(app, line);
  AddQuickstartCommand(app, line);
  AddCompletionCommand(app, line);
  AddManCommand(app, line);
}

int RunLatticectl(int argc, const char* const* argv, Console console) {
  CLI::App app("The command-line client of latticed: accurate free-form deformation of meshes.",
               "latticectl");
  app.set_version_flag("--version", LATTICED_VERSION);
  CommandLine line{.console = console};
  AddCommands(app, line);
  app.footer("'latticectl COMMAND --help' shows the options of a command, and an example.");
  return RunCommandLine(app, line, argc, argv);
}

}  // namespace latticed::client
