// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load generator and the check of a store are separate programs in the same folder: latticectl can be built without
// them, and knows no stores.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct Program {
  const char* what;
  const char* name;
  const char* target;  // of the build
};

constexpr Program kBench{"load generator", "latticectl-bench", "latticectl_bench"};
constexpr Program kStore{"check of a store", "latticectl-store", "latticectl_store"};

// Replaces this process by the program. Returns only if that fails.
absl::Status Start(const Program& started, std::vector<std::string> arguments) {
  std::error_code failure;
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe", failure).replace_filename(started.name);
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  return absl::NotFoundError(
      fmt::format("cannot start the {} {}: {}; in a source tree './dev build {}' makes it",
                  started.what, program.string(), std::strerror(errno), started.target));
}

}  // namespace

void AddBenchCommand(CLI::App& app, CommandLine& line) {
  CLI::App* command =
      app.add_subcommand("bench", "Puts a server under load and measures it; see bench --help");
  command->set_help_flag();  // --help and all other arguments go to the load generator
  command->prefix_command();
  SetExample(*command, kBenchExample);
  SetAction(*command, line, [command] { return Start(kBench, command->remaining()); });
}

void AddStoreCommand(CLI::App& app, CommandLine& line) {
  CLI::App* group = app.add_subcommand("store", "Looks after what a server keeps on disk");
  group->require_subcommand(0, 1);
  CLI::App* check =
      group->add_subcommand("check",
                            "Reads all meshes and scenes in a folder of --data-dir, and names what "
                            "is damaged. Nothing that is kept is "
                            "changed. The server may run. Exit code 1 if anything is damaged");
  const auto folder = std::make_shared<std::string>();
  check->add_option("folder", *folder, "The server's --data-dir")
      ->required()
      ->type_name(kFolderType);
  SetExample(*check, "store check /var/lib/latticed");
  SetAction(*check, line, [folder] { return Start(kStore, {"check", *folder}); });
}

}  // namespace latticed::client
