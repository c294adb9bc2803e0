// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Commands that write what latticectl accepts, for shells and for readers.
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/reference/completion.h"
#include "client/cpp/latticectl/reference/man_page.h"

namespace latticed::client {
namespace {

using CompletionWriter = std::string (*)(const CommandEntry&);
constexpr NamedValues<CompletionWriter, 3> kShells{
    {{"bash", BashCompletion}, {"zsh", ZshCompletion}, {"fish", FishCompletion}}};

// The table of `app` with the options of `bench`, which only the load generator reads.
CommandEntry WholeTable(CLI::App& app) {
  BenchFlags flags;
  CLI::App& bench = *app.get_subcommand("bench");
  bench.set_help_flag("-h,--help", app.get_help_ptr()->get_description());
  DeclareBench(bench, flags);
  return TableOf(app);
}

}  // namespace

void AddCompletionCommand(CLI::App& app, CommandLine& line) {
  auto write = std::make_shared<CompletionWriter>();
  CLI::App* command =
      app.add_subcommand("completion", "Prints a script with which a shell completes latticectl");
  AddNamedOption<CompletionWriter>(
      *command, "shell", kShells, [write](CompletionWriter named) { *write = named; },
      "Which shell; 'source <(latticectl completion bash)' in ~/.bashrc loads its script")
      ->required();
  SetExample(*command, "completion bash");
  SetAction(*command, line, [write, &app, &line] {
    line.console.out << (*write)(WholeTable(app));
    return absl::OkStatus();
  });
}

void AddManCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("man", "Prints the manual page; 'latticectl man | man -l -' shows it");
  SetExample(*command, "man");
  SetAction(*command, line, [&app, &line] {
    line.console.out << ManPage(WholeTable(app), LATTICED_VERSION);
    return absl::OkStatus();
  });
}

}  // namespace latticed::client
