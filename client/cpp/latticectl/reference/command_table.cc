// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/reference/command_table.h"

#include <CLI/CLI.hpp>

#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/command_line/value_types.h"

namespace latticed::client {
namespace {

// CLI11 names a type and its checks in one text: "TEXT:{raw,draco}", "INT:INT in [1 - 32]", "TEXT".
void ReadType(const std::string& type, OptionEntry& entry) {
  const size_t colon = type.find(':');
  entry.value = type.substr(0, colon);
  if (colon == std::string::npos) return;
  const std::string check = type.substr(colon + 1);
  if (check.starts_with('{') && check.ends_with('}')) {
    entry.words = absl::StrSplit(check.substr(1, check.size() - 2), ',');
  } else {
    entry.range = check;
  }
}

OptionEntry EntryOf(const CLI::Option& option) {
  OptionEntry entry;
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  if (entry.names.empty()) entry.names.push_back(option.get_name(/*positional=*/true));
  entry.text = option.get_description();
  entry.required = option.get_required();
  if (option.get_items_expected_max() == 0) return entry;  // a flag
  ReadType(option.get_type_name(), entry);
  entry.default_value = option.get_default_str();
  entry.environment = option.get_envname();
  entry.repeated = TakesAnyNumber(option);
  return entry;
}

// CLI11 keeps a group of options as a command without a name.
void AddOptions(const CLI::App& app, CommandEntry& entry) {
  for (const CLI::Option* option : app.get_options()) {
    auto& list = option->get_positional() ? entry.arguments : entry.options;
    list.push_back(EntryOf(*option));
  }
  for (const CLI::App* below : app.get_subcommands({})) {
    if (below->get_name().empty()) AddOptions(*below, entry);
  }
}

CommandEntry EntryOf(const CLI::App& app, const std::string& path) {
  CommandEntry entry{.path = path, .text = app.get_description(), .footer = app.get_footer()};
  AddOptions(app, entry);
  for (const CLI::App* below : app.get_subcommands({})) {
    const std::string& name = below->get_name();
    if (!name.empty()) entry.commands.push_back(EntryOf(*below, path + " " + name));
  }
  return entry;
}

}  // namespace

CommandEntry TableOf(const CLI::App& app) { return EntryOf(app, app.get_name()); }

std::vector<const CommandEntry*> AllCommands(const CommandEntry& command) {
  std::vector<const CommandEntry*> all{&command};
  for (const CommandEntry& below : command.commands) {
    for (const CommandEntry* each : AllCommands(below)) all.push_back(each);
  }
  return all;
}

}  // namespace latticed::client
