// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/latticectl_app.h"

#include <CLI/CLI.hpp>
#include <map>
#include <ostream>
#include <string>

#include "client/cpp/latticectl/commands.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr int kInterrupted = 128;  // plus the signal's number, as in shells

// Returns how a user can get past a server's refusal; empty where the server's message suffices.
std::string Advice(const error::Details& details) {
  if (details.retry_after_ms > 0) {
    return fmt::format("try again in {:.3g} s", details.retry_after_ms / 1e3);
  }
  static const auto* const kAdvice = new std::map<std::string, std::string>{
      {"UNAUTHENTICATED", "give a token with --token or $LATTICED_TOKEN"},
      {"PERMISSION_DENIED", "use a token with that role"},
      {"OUT_OF_MEMORY",
       "take fewer --segments, or free memory with 'latticectl scene delete' and "
       "'latticectl meshes delete'"},
      {"MESH_IN_USE", "delete its scenes first, or all at once with --force"},
      {"REVISION_CHANGED", "run the command again"},
      {"STRUCTURE_CHANGED", "run the command again"}};
  const auto found = kAdvice->find(details.reason);
  if (found != kAdvice->end()) return found->second;
  const auto kind = details.metadata.find("kind");
  if (details.reason != "NOT_FOUND" || kind == details.metadata.end()) return "";
  if (kind->second == "scene") return "'latticectl scene list' shows what there is";
  return kind->second == "mesh" ? "'latticectl meshes' shows what there is" : "";
}

// Prints one sentence. In parentheses: the reason, and the request's id in the server's log.
void PrintFailure(const absl::Status& status, std::ostream& err) {
  const error::Details details = error::DetailsOf(status);
  const std::string advice = Advice(details);
  const auto request = details.metadata.find("request_id");
  err << fmt::format(
      "latticectl: {}{}{} ({}{})\n", std::string(status.message()), advice.empty() ? "" : "; ",
      advice, details.reason.empty() ? absl::StatusCodeToString(status.code()) : details.reason,
      request == details.metadata.end() ? "" : ", request " + request->second);
}

}  // namespace

void SetAction(CLI::App& command, CommandLine& line, std::function<absl::Status()> run) {
  command.callback([&command, &line, run = std::move(run)] {
    if (command.get_subcommands().empty()) line.action = run;
  });
}

int RunCommandLine(CLI::App& app, CommandLine& line, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e, line.console.out, line.console.err) == 0 ? 0 : kWrongUsage;
  }
  const absl::Status status = line.action();
  if (status.ok()) return 0;
  if (const int signal = line.interruption.signal(); signal != 0) {
    line.console.err << "latticectl: interrupted\n";
    return kInterrupted + signal;
  }
  PrintFailure(status, line.console.err);
  return kFailed;
}

int RunLatticectl(int argc, const char* const* argv, Console console) {
  CLI::App app("The command-line client of latticed: accurate free-form deformation of meshes.",
               "latticectl");
  app.set_version_flag("--version", LATTICED_VERSION);
  app.require_subcommand(1);
  CommandLine line{.console = console};
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
  return RunCommandLine(app, line, argc, argv);
}

}  // namespace latticed::client
