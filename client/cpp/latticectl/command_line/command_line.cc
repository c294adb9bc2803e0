// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ostream>
#include <string>
#include <string_view>

#include "client/cpp/latticectl/command_line/failure.h"

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
  const bool as_json = line.as_json = WantsJson(argc, argv);
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
  if (status.ok()) return line.exit_code;
  if (const int signal = line.interruption.signal(); signal != 0) {
    PrintFailure(
        {.message = "interrupted", .code = absl::StatusCodeToString(absl::StatusCode::kCancelled)},
        as_json, line.console.err);
    return kInterrupted + signal;
  }
  PrintFailure(FailureOf(status, app), as_json, line.console.err);
  return kFailed;
}

}  // namespace latticed::client
