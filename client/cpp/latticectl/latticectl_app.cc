// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/latticectl_app.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ostream>
#include <string>
#include <string_view>

#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/failure.h"

namespace latticed::client {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kInterrupted = 128;  // plus the signal's number, as in shells

// Also holds for command lines that cannot be parsed.
bool WantsJson(int argc, const char* const* argv) {
  return std::any_of(argv, argv + argc,
                     [](const char* argument) { return std::string_view(argument) == "--json"; });
}

}  // namespace

void SetAction(CLI::App& command, CommandLine& line, std::function<absl::Status()> run) {
  command.callback([&command, &line, run = std::move(run)] {
    if (command.get_subcommands().empty()) line.action = run;
  });
}

void SetExample(CLI::App& command, const char* arguments) {
  command.footer(std::string("Example: latticectl ") + arguments);
}

int RunCommandLine(CLI::App& app, CommandLine& line, int argc, const char* const* argv) {
  const bool as_json = WantsJson(argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version, line.console.out, line.console.err);
  } catch (const CLI::ParseError& e) {
    PrintFailure(FailureOf(e, app), as_json, line.console.err);
    return kWrongUsage;
  }
  if (!line.action) {  // no command, or a group without its command
    line.console.out << app.help();
    return 0;
  }
  const absl::Status status = line.action();
  if (status.ok()) return 0;
  if (const int signal = line.interruption.signal(); signal != 0) {
    PrintFailure(
        {.message = "interrupted", .code = absl::StatusCodeToString(absl::StatusCode::kCancelled)},
        as_json, line.console.err);
    return kInterrupted + signal;
  }
  PrintFailure(FailureOf(status), as_json, line.console.err);
  return kFailed;
}

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
  AddWatchCommand(app, line);
  AddExportCommand(app, line);
  AddBenchCommand(app, line);
  AddQuickstartCommand(app, line);
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
