// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All commands and options of a program as plain values, read from its CLI11 App. The man page and the shells'
// completions are written from this table, so they have what the program accepts.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMMAND_TABLE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMMAND_TABLE_H_

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace latticed::client {

// An option, or an argument without a name of its own.
struct OptionEntry {
  std::vector<std::string> names;  // "-o", "--output"; of an argument "mesh"
  std::string value;               // "FILE", "INT"; empty for a flag
  std::string range;               // "INT in [1 - 32]"; empty: any value of the type
  std::vector<std::string> words;  // the only values; empty: any
  std::string text;
  std::string default_value;  // empty: none
  std::string environment;    // a variable that replaces the option; empty: none
  bool required = false;
  bool repeated = false;  // takes any number of values

  [[nodiscard]] bool takes_value() const { return !value.empty(); }
};

struct CommandEntry {
  std::string path;  // "latticectl scene create"
  std::string text;
  std::string footer;
  std::vector<OptionEntry> arguments;  // in their order
  std::vector<OptionEntry> options;
  std::vector<CommandEntry> commands;  // below this one

  // The last word of the path.
  [[nodiscard]] std::string name() const { return path.substr(path.rfind(' ') + 1); }
};

[[nodiscard]] CommandEntry TableOf(const CLI::App& app);

// The command and those below it, each before those below.
[[nodiscard]] std::vector<const CommandEntry*> AllCommands(const CommandEntry& command);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMMAND_TABLE_H_
