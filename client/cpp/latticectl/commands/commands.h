// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The commands of latticectl, one file each; torture is in a folder of its own. Add… declares a command's options and its action.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_COMMANDS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_COMMANDS_H_

#include "client/cpp/latticectl/command_line/command_line.h"

namespace CLI {
class App;
}

namespace latticed::client {

// Adds all of the commands below, and torture.
void AddCommands(CLI::App& app, CommandLine& line);

void AddInfoCommand(CLI::App& app, CommandLine& line);
void AddSampleCommand(CLI::App& app, CommandLine& line);
void AddMeshCommands(CLI::App& app, CommandLine& line);  // upload, meshes [delete]
void AddLatticeCommand(CLI::App& app, CommandLine& line);
void AddApplyCommand(CLI::App& app, CommandLine& line);
void AddSceneCommands(CLI::App& app, CommandLine& line);  // scene create|list|show|delete
void AddShareCommands(CLI::App& app, CommandLine& line);  // share create|list|revoke
void AddEditCommands(CLI::App& app, CommandLine& line);   // edit move|set|drag|…
void AddPickCommand(CLI::App& app, CommandLine& line);
void AddFoldsCommand(CLI::App& app, CommandLine& line);
void AddMeasureCommand(CLI::App& app, CommandLine& line);
void AddWatchCommand(CLI::App& app, CommandLine& line);
void AddExportCommand(CLI::App& app, CommandLine& line);
void AddPointsCommands(CLI::App& app, CommandLine& line);  // points deform|gradient|…
void AddBenchCommand(CLI::App& app, CommandLine& line);    // starts latticectl-bench
void AddStoreCommand(CLI::App& app, CommandLine& line);    // store check: starts latticectl-store
void AddQuickstartCommand(CLI::App& app, CommandLine& line);
void AddBackupCommands(CLI::App& app, CommandLine& line);  // backup, restore
void AddCompletionCommand(CLI::App& app, CommandLine& line);
void AddManCommand(CLI::App& app, CommandLine& line);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_COMMANDS_H_
