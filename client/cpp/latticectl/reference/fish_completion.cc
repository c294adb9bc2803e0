// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/reference/completion.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// Prints the command that the words before the cursor name.
constexpr char kFishWalk[] = R"(function __latticectl_command
    set -l command latticectl
    for word in (commandline -opc)[2..-1]
        if contains -- "$command $word" $__latticectl_commands
            set command "$command $word"
        end
    end
    echo $command
end

complete -c latticectl -f
)";

std::string FishQuoted(const std::string& text) {
  return "'" + absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"'", "\\'"}}) + "'";
}

// A completion that holds for one command.
std::string Rule(const CommandEntry& command, const std::string& what, const std::string& text) {
  return fmt::format("complete -c latticectl -n 'test (__latticectl_command) = \"{}\"' {} -d {}\n",
                     command.path, what, FishQuoted(text));
}

// How to complete a value: -r: one must follow; -F: files; -x: only the words of -a.
std::string FishValue(const OptionEntry& option) {
  if (option.value == kFileType) return "-r -F";
  if (option.value == kFolderType) return "-x -a '(__fish_complete_directories)'";
  return "-x -a " + FishQuoted(absl::StrJoin(option.words, " "));
}

std::string OptionRule(const CommandEntry& command, const OptionEntry& option) {
  std::string what;
  for (const std::string& name : option.names) {
    what += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (option.takes_value()) what += " " + FishValue(option);
  return Rule(command, what.substr(1), option.text);
}

std::string ArgumentRule(const CommandEntry& command, const OptionEntry& argument) {
  if (argument.value == kFileType) return Rule(command, "-F", argument.text);
  if (argument.words.empty()) return "";
  return Rule(command, "-a " + FishQuoted(absl::StrJoin(argument.words, " ")), argument.text);
}

}  // namespace

std::string FishCompletion(const CommandEntry& program) {
  std::string commands, rules;
  for (const CommandEntry* command : AllCommands(program)) {
    if (command != &program) commands += " " + FishQuoted(command->path);
    for (const auto& below : command->commands) {
      rules += Rule(*command, "-a " + below.name(), below.text);
    }
    for (const auto& option : command->options) rules += OptionRule(*command, option);
    for (const auto& argument : command->arguments) rules += ArgumentRule(*command, argument);
  }
  return "# Completion of latticectl in fish, by 'latticectl completion fish'.\n\nset -g "
         "__latticectl_commands" +
         commands + "\n\n" + kFishWalk + rules;
}

}  // namespace latticed::client
