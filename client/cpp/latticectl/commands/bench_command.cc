// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load generator is a separate program in the same folder, so latticectl can be built without it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr char kBenchProgram[] = "latticectl-bench";

// Replaces this process by the load generator. Returns only if that fails.
absl::Status StartBench(std::vector<std::string> arguments) {
  std::error_code failure;
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe", failure).replace_filename(kBenchProgram);
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  return absl::NotFoundError(
      fmt::format("cannot start the load generator {}: {}; in a source tree './dev build "
                  "latticectl_bench' makes it",
                  program.string(), std::strerror(errno)));
}

}  // namespace

void AddBenchCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("bench", "Puts a server under load and measures it; see bench --help");
  command->set_help_flag();  // --help and all other arguments go to the load generator
  command->prefix_command();
  SetExample(*command, kBenchExample);
  SetAction(*command, line, [command] { return StartBench(command->remaining()); });
}

}  // namespace latticed::client
